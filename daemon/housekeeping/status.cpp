#include "daemon/housekeeping/status.hpp"

#include <unistd.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <numeric>

#include <fmt/format.h>

#include "daemon/core/conditions.hpp"
#include "daemon/core/pipeline.hpp"
#include "daemon/core/record.hpp"
#include "daemon/sockets/json.hpp"
#include "estimator/common/measurement.hpp"

namespace odomd::daemon {
namespace {

constexpr double ns_per_s = 1e9;
constexpr double ns_per_us = 1e3;

constexpr std::array<std::string_view, 4> link_names{"up", "down", "gone", "ended"};

double seconds(std::int64_t ns) {
  return static_cast<double>(ns) / ns_per_s;
}

/// Seconds since a time; null when it was never set.
double age_of(std::int64_t last_ns, std::int64_t now_ns) {
  return last_ns == 0 ? NAN : seconds(now_ns - last_ns);
}

/// A positive number; null while it is not estimated.
double estimated(double value) {
  return value > 0.0 ? value : NAN;
}

void write_head(JsonWriter& json, const Running& running, const PublishedPose& published,
                std::int64_t now_ns) {
  const odom_info& info = running.writer.info();
  json.member("version", ODOMD_VERSION);
  json.member("instance", fmt::format("{:016x}", info.instance_id));
  json.member("pid", ::getpid());
  json.member("uptime_s", seconds(now_ns - running.started_ns));
  json.member("config", running.config.file.string());
  json.member("shm", running.config.shm.name);
  json.member("model", name_of(running.config.model));
  json.member("mode", odom_mode_name(published.pose.mode));
  json.list("conditions", condition_names(published.valid ? published.pose.conditions : 0));
}

void write_pose(JsonWriter& json, const PublishedPose& published, std::int64_t now_ns) {
  const odom_pose& pose = published.pose;
  json.begin_object("pose");
  json.member("tick", pose.tick);
  json.member("time_ns", pose.time_ns);
  json.member("age_s", seconds(now_ns - pose.time_ns));
  json.member("x", pose.x);
  json.member("y", pose.y);
  json.member("yaw", pose.yaw);
  json.member("vx", pose.vx);
  json.member("vy", pose.vy);
  json.member("yaw_rate", pose.yaw_rate);
  json.member("steering", pose.steering);
  // Diagonal of the packed triangle xx, xy, xyaw, yy, yyaw, yawyaw.
  json.member("sigma_x", std::sqrt(pose.covariance[0]));
  json.member("sigma_y", std::sqrt(pose.covariance[3]));
  json.member("sigma_yaw", std::sqrt(pose.covariance[5]));
  json.member("reset_count", pose.reset_count);
  json.end_object();
}

void write_calibrations(JsonWriter& json, const odom_details& details) {
  json.begin_array("calibrations");
  for (std::size_t i = 0; i < calibrations.size(); ++i) {
    json.begin_object();
    json.member("name", calibrations[i].name);
    json.member("value", details.*calibrations[i].value);
    json.member("sigma", estimated(calibration_sigma(details, i)));
    json.member("valid", (details.calibration_valid >> i & 1U) != 0);
    json.end_object();
  }
  json.end_array();
}

void write_histogram(JsonWriter& json, std::string_view key,
                     const std::uint64_t (&histogram)[ODOM_HISTOGRAM_BUCKETS],
                     std::int64_t max_ns) {
  json.begin_object(key);
  json.member("p50", percentile_us(histogram, 0.5, max_ns));
  json.member("p99", percentile_us(histogram, 0.99, max_ns));
  json.member("p999", percentile_us(histogram, 0.999, max_ns));
  json.member("max", static_cast<double>(max_ns) / ns_per_us);
  json.end_object();
}

void write_beat(JsonWriter& json, const Running& running, std::int64_t now_ns) {
  const odom_beat beat = running.writer.beat();
  json.begin_object("beat");
  json.member("period_s", seconds(running.config.realtime.period_ns));
  json.member("ticks", beat.ticks);
  json.member("missed", beat.missed);
  json.member("overruns", beat.overruns);
  json.member("carried_over", beat.carried_over);
  json.member("last_overrun_age_s", age_of(beat.last_overrun_ns, now_ns));
  json.member("last_overrun_execution_us",
              beat.last_overrun_ns == 0
                  ? NAN
                  : static_cast<double>(beat.last_overrun_execution_ns) / ns_per_us);
  write_histogram(json, "wakeup_us", beat.wakeup, beat.max_wakeup_ns);
  write_histogram(json, "execution_us", beat.execution, beat.max_execution_ns);
  json.end_object();
}

void write_bit_timing(JsonWriter& json, const std::optional<can::BitTiming>& timing) {
  if (!timing) {
    json.member("bit_timing", NAN);
    return;
  }
  json.begin_object("bit_timing");
  json.member("bitrate", timing->bitrate);
  // Drivers of adapters with their own firmware may only know the bit rate.
  const bool divided = timing->time_quantum_ns != 0;
  const auto part = [&](std::string_view key, std::uint32_t value) {
    json.member(key, divided ? std::optional(value) : std::nullopt);
  };
  json.member("sample_point", divided ? timing->sample_point_permille / 1000.0 : NAN);
  part("tq_ns", timing->time_quantum_ns);
  part("prop_seg", timing->prop_seg);
  part("phase_seg1", timing->phase_seg1);
  part("phase_seg2", timing->phase_seg2);
  part("sjw", timing->sjw);
  part("brp", timing->brp);
  json.end_object();
}

/// Writes null for vcan and logs, and when the driver does not report the controller.
void write_controller(JsonWriter& json, const std::optional<can::Controller>& controller) {
  if (!controller) {
    json.member("controller", NAN);
    return;
  }
  json.begin_object("controller");
  json.member("state", can::name_of(controller->health));
  json.member("restart_ms", controller->restart_ms);
  write_bit_timing(json, controller->bit_timing);
  json.member("clock_hz", controller->clock_hz);
  json.list("modes", controller->modes);
  const auto& errors = controller->errors;
  json.member("tx_errors", errors ? std::optional(errors->transmit) : std::nullopt);
  json.member("rx_errors", errors ? std::optional(errors->receive) : std::nullopt);
  const auto statistic = [&](std::string_view key,
                             std::uint32_t can::ControllerStatistics::*count) {
    const auto& statistics = controller->statistics;
    json.member(key, statistics ? std::optional((*statistics).*count) : std::nullopt);
  };
  statistic("bus_errors", &can::ControllerStatistics::bus_errors);
  statistic("error_warnings", &can::ControllerStatistics::error_warnings);
  statistic("error_passives", &can::ControllerStatistics::error_passives);
  statistic("bus_offs", &can::ControllerStatistics::bus_offs);
  statistic("arbitration_lost", &can::ControllerStatistics::arbitration_lost);
  statistic("restarts", &can::ControllerStatistics::restarts);
  json.end_object();
}

void write_buses(JsonWriter& json, const Running& running) {
  json.begin_array("can");
  for (std::size_t bus = 0; bus < running.sources.size(); ++bus) {
    const can::FrameSource& source = *running.sources[bus];
    const can::SourceCounters& counters = source.counters();
    json.begin_object();
    json.member("name", source.name());
    json.member("link", link_names[static_cast<std::size_t>(source.link())]);
    json.member("received", counters.received.get());
    json.member("lost", counters.lost.get());
    json.member("error_frames", counters.error_frames.get());
    json.member("carried_over", counters.carried_over.get());
    json.member("link_downs", counters.link_downs.get());
    json.member("stamp_fallbacks", counters.stamp_fallbacks.get());
    json.member("malformed", counters.malformed.get());
    json.member("hardware_fallbacks", counters.hardware_fallbacks.get());
    json.member("clock_steps", counters.clock_steps.get());
    json.member("bus_offs", counters.bus_offs.get());
    json.member("controller_overflows", counters.controller_overflows.get());
    write_controller(json, running.controllers.latest(bus));
    json.end_object();
  }
  json.end_array();
}

void write_messages(JsonWriter& json, const Running& running, std::int64_t now_ns) {
  const can::Decoder& decoder = running.pipeline.decoder();
  json.begin_array("messages");
  for (std::size_t i = 0; i < decoder.messages().size(); ++i) {
    const can::BoundMessage& message = decoder.messages()[i];
    const can::MessageCounters& counters = decoder.counters(i);
    json.begin_object();
    json.member("name", message.name);
    json.member("id", message.id);
    json.member("extended", message.format == can::IdFormat::extended);
    json.member("cycle_time_s", seconds(message.cycle_time_ns));
    json.member("age_s", age_of(static_cast<std::int64_t>(counters.last_time_ns.get()), now_ns));
    json.counts("verdicts", can::frame_verdict_names, counters.verdicts);
    json.member("some_lost", counters.some_lost.get());
    json.end_object();
  }
  json.end_array();

  const PipelineStatistics& statistics = running.pipeline.statistics();
  json.counts("frames", can::frame_verdict_names, statistics.frames);
  json.counts("stamps", can::stamp_verdict_names, statistics.stamps);
}

/// `anchored`: camera poses were taken. A model that does not report each test gives only the ratio
/// of the last one.
void write_innovations(JsonWriter& json, const SourceStatistics& source, bool anchored) {
  const InnovationStatistics& statistics = source.innovations;
  const bool tested = statistics.count() > 0;
  json.member("test_ratio", tested     ? statistics.last_test_ratio()
                            : anchored ? source.last_test_ratio.get()
                                       : NAN);
  const std::array<double, 3> innovation = statistics.last_innovation();
  json.list("innovation",
            std::span(innovation).first(static_cast<std::size_t>(statistics.dimension())));
  json.begin_object("innovations");
  json.member("count", statistics.count());
  json.member("gated", statistics.gated());
  json.member("dimension", statistics.dimension());
  json.member("mean_nis", tested ? statistics.mean_nis() : NAN);
  json.member("inside_95", tested ? statistics.inside_95() : NAN);
  json.end_object();
}

void write_sources(JsonWriter& json, const Running& running, const PublishedPose& published,
                   std::int64_t now_ns) {
  constexpr auto camera = static_cast<std::size_t>(estimator::Source::camera);
  const Config& config = running.config;
  json.begin_array("sources");
  for (std::size_t i = 0; i < estimator::source_count; ++i) {
    const SourceStatistics& source = running.pipeline.statistics().sources[i];
    const SignalSettings& settings = config.can.signals[i];
    const bool by_camera = i == camera;
    json.begin_object();
    json.member("name", estimator::source_names[i]);
    json.member("configured", by_camera ? config.camera.configured : settings.configured);
    json.member("healthy", published.valid && (published.pose.health >> i & 1U) != 0);
    json.member("flag", estimator::source_flag_names[std::min<std::size_t>(
                            source.flag.get(), estimator::source_flag_names.size() - 1)]);
    json.member("wiring",
                wiring_names[std::min<std::size_t>(source.wiring.get(), wiring_names.size() - 1)]);
    json.member("inconsistent", source.inconsistent.get() != 0);
    json.member("age_s", age_of(source.last_time_ns.get(), now_ns));
    json.member("timeout_s", settings.configured ? seconds(settings.timeout_ns) : NAN);
    json.member("sigma", settings.configured ? settings.sigma : NAN);
    const estimator::SourceNoise noise = source.noise.get();
    json.begin_object("noise");
    json.member("at_rest", estimated(noise.at_rest));
    json.member("moving", estimated(noise.moving));
    json.member("speed_share", estimated(noise.speed_share));
    json.end_object();
    const std::uint64_t seen = source.judged();
    const auto last =
        std::min<std::size_t>(source.last_verdict.get(), estimator::verdict_count - 1);
    json.member("last_verdict", seen == 0 ? "none" : estimator::verdict_names[last]);
    write_innovations(json, source, by_camera && seen > 0);
    json.counts("verdicts", estimator::verdict_names, source.verdicts);
    json.end_object();
  }
  json.end_array();
}

void write_camera(JsonWriter& json, const Running& running) {
  const BeatCounters& counters = running.beat.counters();
  json.begin_object("camera");
  json.member("socket", running.config.camera.configured ? running.config.camera.socket.string()
                                                         : std::string());
  json.member("messages", counters.camera_messages.get());
  json.member("malformed", counters.camera_malformed.get());
  const SourceStatistics& source =
      running.pipeline.statistics().sources[static_cast<std::size_t>(estimator::Source::camera)];
  json.member("last_latency_s",
              source.last_time_ns.get() == 0 ? NAN : seconds(source.last_latency_ns.get()));
  json.begin_array("connections");
  for (const auto& connection : running.cameras.connections()) {
    if (!connection.open) continue;
    json.begin_object();
    json.member("pid", connection.peer.pid);
    json.member("uid", connection.peer.uid);
    json.member("messages", connection.messages);
    json.member("malformed", connection.malformed);
    json.end_object();
  }
  json.end_array();
  json.end_object();
}

void write_clock(JsonWriter& json, const Running& running) {
  const BeatCounters& counters = running.beat.counters();
  json.begin_object("clock");
  json.member("realtime_offset_ns", static_cast<std::int64_t>(counters.realtime_offset_ns.get()));
  json.member("log_offset_ns", running.log_clock.offset_ns().value_or(0));
  json.member("steps", counters.clock_steps.get());
  json.member("suspends", counters.suspends.get());
  json.end_object();
}

void write_realtime(JsonWriter& json, const RealtimeFacts& facts) {
  json.begin_object("realtime");
  json.member("priority", facts.priority);
  json.member("cpu", facts.cpu);
  json.member("memory_locked", facts.memory_locked);
  json.member("dma_latency_held", facts.dma_latency_held);
  json.list("refusals", facts.refusals);
  json.end_object();
}

}  // namespace

std::string status_json(const Running& running, const PublishedPose& published,
                        std::int64_t now_ns) {
  JsonWriter json;
  json.begin_object();
  write_head(json, running, published, now_ns);
  if (published.valid) {
    write_pose(json, published, now_ns);
    write_calibrations(json, published.details);
  }
  write_beat(json, running, now_ns);
  write_buses(json, running);
  write_messages(json, running, now_ns);
  write_sources(json, running, published, now_ns);
  write_camera(json, running);
  write_clock(json, running);
  write_realtime(json, running.realtime);
  json.member("events_dropped", running.events.dropped());
  json.end_object();
  return json.text() + "\n";
}

double percentile_us(std::span<const std::uint64_t, ODOM_HISTOGRAM_BUCKETS> histogram, double share,
                     std::int64_t max_ns) {
  const auto total = std::accumulate(histogram.begin(), histogram.end(), std::uint64_t{0});
  const double max_us = static_cast<double>(max_ns) / ns_per_us;
  const auto wanted = static_cast<std::uint64_t>(std::ceil(share * static_cast<double>(total)));
  std::uint64_t sum = 0;
  for (std::size_t bucket = 0; bucket + 1 < histogram.size(); ++bucket) {
    sum += histogram[bucket];
    // The upper edge of bucket i is 2^(i/4) us.
    if (sum >= wanted) return std::min(max_us, std::exp2(static_cast<double>(bucket) / 4.0));
  }
  return max_us;
}

}  // namespace odomd::daemon
