#include "daemon/housekeeping/status.hpp"

#include <unistd.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <iterator>
#include <nlohmann/json.hpp>
#include <numeric>
#include <optional>

#include <fmt/format.h>

#include "daemon/core/conditions.hpp"
#include "daemon/core/pipeline.hpp"
#include "daemon/core/record.hpp"
#include "estimator/common/measurement.hpp"

namespace odomd::daemon {
namespace {

using Json = nlohmann::ordered_json;

constexpr double ns_per_us = 1e3;

constexpr std::array<std::string_view, 4> link_names{"up", "down", "gone", "ended"};

constexpr auto camera = static_cast<std::size_t>(estimator::Source::camera);

// Divides, so that JSON has the shortest digits.
double decimal_seconds(std::int64_t ns) {
  return static_cast<double>(ns) / 1e9;
}

/// Seconds since a time; NaN, which JSON writes as null, when it was never set.
double age_of(std::int64_t last_ns, std::int64_t now_ns) {
  return last_ns == 0 ? NAN : decimal_seconds(now_ns - last_ns);
}

/// A positive number; NaN while it is not estimated.
double estimated(double value) {
  return value > 0.0 ? value : NAN;
}

/// Null for a value that is not known.
template <typename T>
Json or_null(const std::optional<T>& value) {
  return value ? Json(*value) : Json();
}

/// An object with a counter for each name.
Json counts_json(const auto& names, const auto& counters) {
  Json json = Json::object();
  for (std::size_t i = 0; i < std::size(counters); ++i) json[names[i]] = counters[i].get();
  return json;
}

Json pose_json(const odom_pose& pose, std::int64_t now_ns) {
  return {{"tick", pose.tick},
          {"time_ns", pose.time_ns},
          {"age_s", decimal_seconds(now_ns - pose.time_ns)},
          {"x", pose.x},
          {"y", pose.y},
          {"yaw", pose.yaw},
          {"vx", pose.vx},
          {"vy", pose.vy},
          {"yaw_rate", pose.yaw_rate},
          {"steering", pose.steering},
          // Diagonal of the packed triangle xx, xy, xyaw, yy, yyaw, yawyaw.
          {"sigma_x", std::sqrt(pose.covariance[0])},
          {"sigma_y", std::sqrt(pose.covariance[3])},
          {"sigma_yaw", std::sqrt(pose.covariance[5])},
          {"reset_count", pose.reset_count}};
}

Json calibrations_json(const odom_details& details) {
  Json json = Json::array();
  for (std::size_t i = 0; i < calibrations.size(); ++i)
    json.push_back({{"name", calibrations[i].name},
                    {"value", details.*calibrations[i].value},
                    {"sigma", estimated(calibration_sigma(details, i))},
                    {"valid", (details.calibration_valid >> i & 1U) != 0}});
  return json;
}

Json histogram_json(const std::uint64_t (&histogram)[ODOM_HISTOGRAM_BUCKETS], std::int64_t max_ns) {
  return {{"p50", percentile_us(histogram, 0.5, max_ns)},
          {"p99", percentile_us(histogram, 0.99, max_ns)},
          {"p999", percentile_us(histogram, 0.999, max_ns)},
          {"max", static_cast<double>(max_ns) / ns_per_us}};
}

Json beat_json(const Running& running, std::int64_t now_ns) {
  const odom_beat beat = running.writer.beat();
  const double last_execution_us = static_cast<double>(beat.last_overrun_execution_ns) / ns_per_us;
  return {{"period_s", decimal_seconds(running.config.realtime.period_ns)},
          {"ticks", beat.ticks},
          {"missed", beat.missed},
          {"overruns", beat.overruns},
          {"carried_over", beat.carried_over},
          {"last_overrun_age_s", age_of(beat.last_overrun_ns, now_ns)},
          {"last_overrun_execution_us", beat.last_overrun_ns == 0 ? NAN : last_execution_us},
          {"wakeup_us", histogram_json(beat.wakeup, beat.max_wakeup_ns)},
          {"execution_us", histogram_json(beat.execution, beat.max_execution_ns)}};
}

Json bit_timing_json(const std::optional<can_bittiming>& timing) {
  if (!timing) return {};
  // Drivers of adapters with their own firmware may only know the bit rate.
  const bool divided = timing->tq != 0;
  const auto part = [divided](auto value) { return divided ? Json(value) : Json(); };
  return {{"bitrate", timing->bitrate},
          {"sample_point", part(timing->sample_point / 1000.0)},
          {"tq_ns", part(timing->tq)},
          {"prop_seg", part(timing->prop_seg)},
          {"phase_seg1", part(timing->phase_seg1)},
          {"phase_seg2", part(timing->phase_seg2)},
          {"sjw", part(timing->sjw)},
          {"brp", part(timing->brp)}};
}

/// Null for vcan and logs, and when the driver does not report the controller.
Json controller_json(const std::optional<can::Controller>& controller) {
  if (!controller) return {};
  // The member of an optional struct, or null.
  const auto part = [](const auto& all, auto member) {
    return all ? Json((*all).*member) : Json();
  };
  const auto& errors = controller->errors;
  const auto& statistics = controller->statistics;
  using Statistics = can_device_stats;
  return {{"state", can::name_of(controller->health)},
          {"restart_ms", or_null(controller->restart_ms)},
          {"bit_timing", bit_timing_json(controller->bit_timing)},
          {"clock_hz", or_null(controller->clock_hz)},
          {"modes", controller->modes},
          {"tx_errors", part(errors, &can_berr_counter::txerr)},
          {"rx_errors", part(errors, &can_berr_counter::rxerr)},
          {"bus_errors", part(statistics, &Statistics::bus_error)},
          {"error_warnings", part(statistics, &Statistics::error_warning)},
          {"error_passives", part(statistics, &Statistics::error_passive)},
          {"bus_offs", part(statistics, &Statistics::bus_off)},
          {"arbitration_lost", part(statistics, &Statistics::arbitration_lost)},
          {"restarts", part(statistics, &Statistics::restarts)}};
}

Json bus_json(const can::FrameSource& source, const std::optional<can::Controller>& controller) {
  const can::SourceCounters& counters = source.counters();
  return {{"name", source.name()},
          {"link", link_names[static_cast<std::size_t>(source.link())]},
          {"received", counters.received.get()},
          {"lost", counters.lost.get()},
          {"error_frames", counters.error_frames.get()},
          {"carried_over", counters.carried_over.get()},
          {"link_downs", counters.link_downs.get()},
          {"stamp_fallbacks", counters.stamp_fallbacks.get()},
          {"malformed", counters.malformed.get()},
          {"hardware_fallbacks", counters.hardware_fallbacks.get()},
          {"clock_steps", counters.clock_steps.get()},
          {"bus_offs", counters.bus_offs.get()},
          {"controller_overflows", counters.controller_overflows.get()},
          {"controller", controller_json(controller)}};
}

Json message_json(const can::BoundMessage& message, const can::MessageCounters& counters,
                  std::int64_t now_ns) {
  return {{"name", message.name},
          {"id", message.id},
          {"extended", message.format == can::IdFormat::extended},
          {"cycle_time_s", decimal_seconds(message.cycle_time_ns)},
          {"age_s", age_of(static_cast<std::int64_t>(counters.last_time_ns.get()), now_ns)},
          {"verdicts", counts_json(can::frame_verdict_names, counters.verdicts)},
          {"some_lost", counters.some_lost.get()}};
}

Json innovations_json(const InnovationStatistics& tested) {
  return {{"count", tested.count},
          {"gated", tested.gated},
          {"dimension", tested.dimension},
          {"mean_nis", tested.count > 0 ? tested.mean_nis() : NAN},
          {"inside_95", tested.count > 0 ? tested.inside_95() : NAN}};
}

/// `index` is that of an estimator::Source.
Json source_json(std::size_t index, const Running& running, const PublishedPose& published,
                 std::int64_t now_ns) {
  const SourceStatistics& source = running.pipeline.statistics().sources[index];
  const SignalSettings& settings = running.config.can.signals[index];
  const bool is_camera = index == camera;
  const auto name = [](const auto& names, const Counter& value) {
    return names[std::min<std::size_t>(value.get(), std::size(names) - 1)];
  };
  const estimator::SourceNoise noise = source.noise.get();
  const std::uint64_t judged = source.judged();
  const InnovationStatistics innovations = source.innovations.get();
  // A model that does not report each test gives only the ratio of the last camera test.
  const double test_ratio = innovations.count > 0     ? innovations.test_ratio
                            : is_camera && judged > 0 ? source.last_test_ratio.get()
                                                      : NAN;
  return {
      {"name", estimator::source_names[index]},
      {"configured", is_camera ? running.config.camera.configured : settings.configured},
      {"healthy", published.valid && (published.pose.health >> index & 1U) != 0},
      {"flag", name(estimator::source_flag_names, source.flag)},
      {"wiring", name(wiring_names, source.wiring)},
      {"inconsistent", source.inconsistent.get() != 0},
      {"age_s", age_of(source.last_time_ns.get(), now_ns)},
      {"timeout_s", settings.configured ? decimal_seconds(settings.timeout_ns) : NAN},
      {"sigma", settings.configured ? settings.sigma : NAN},
      {"noise",
       {{"at_rest", estimated(noise.at_rest)},
        {"moving", estimated(noise.moving)},
        {"speed_share", estimated(noise.speed_share)}}},
      {"last_verdict", judged == 0 ? "none" : name(estimator::verdict_names, source.last_verdict)},
      {"test_ratio", test_ratio},
      {"innovation", std::span(innovations.innovation).first(innovations.dimension)},
      {"innovations", innovations_json(innovations)},
      {"verdicts", counts_json(estimator::verdict_names, source.verdicts)}};
}

Json camera_json(const Running& running) {
  const BeatCounters& counters = running.beat.counters();
  const SourceStatistics& source = running.pipeline.statistics().sources[camera];
  const bool seen = source.last_time_ns.get() != 0;
  Json connections = Json::array();
  for (const auto& connection : running.cameras.connections())
    if (connection.open)
      connections.push_back({{"pid", connection.peer.pid},
                             {"uid", connection.peer.uid},
                             {"messages", connection.messages},
                             {"malformed", connection.malformed}});
  const CameraConfig& config = running.config.camera;
  return {{"socket", config.configured ? config.socket.path.string() : ""},
          {"messages", counters.camera_messages.get()},
          {"malformed", counters.camera_malformed.get()},
          {"last_latency_s", seen ? decimal_seconds(source.last_latency_ns.get()) : NAN},
          {"connections", connections}};
}

Json clock_json(const Running& running) {
  const BeatCounters& counters = running.beat.counters();
  return {{"realtime_offset_ns", static_cast<std::int64_t>(counters.realtime_offset_ns.get())},
          {"log_offset_ns", running.log_clock.offset_ns().value_or(0)},
          {"steps", counters.clock_steps.get()},
          {"suspends", counters.suspends.get()}};
}

Json realtime_json(const MachineGrant& machine, const ThreadGrant& beat) {
  return {{"priority", beat.priority},
          {"cpu", beat.cpu},
          {"memory_locked", machine.memory_locked},
          {"dma_latency_held", static_cast<bool>(machine.dma_latency)},
          {"refusals", machine.refusals}};
}

}  // namespace

std::string status_json(const Running& running, const PublishedPose& published,
                        std::int64_t now_ns) {
  const std::uint32_t raised = published.valid ? published.pose.conditions : 0;
  Json json{{"version", ODOMD_VERSION},
            {"instance", fmt::format("{:016x}", running.writer.info().instance_id)},
            {"pid", ::getpid()},
            {"uptime_s", decimal_seconds(now_ns - running.started_ns)},
            {"config", running.config.file.string()},
            {"shm", running.config.shm.name},
            {"model", name_of(running.config.model)},
            {"mode", odom_mode_name(published.pose.mode)},
            {"conditions", condition_names(raised)}};
  if (published.valid) {
    json["pose"] = pose_json(published.pose, now_ns);
    json["calibrations"] = calibrations_json(published.details);
  }
  json["beat"] = beat_json(running, now_ns);
  for (std::size_t bus = 0; bus < running.sources.size(); ++bus)
    json["can"].push_back(bus_json(*running.sources[bus], running.controllers.latest(bus)));
  const can::Decoder& decoder = running.pipeline.decoder();
  for (std::size_t i = 0; i < decoder.messages().size(); ++i)
    json["messages"].push_back(message_json(decoder.messages()[i], decoder.counters(i), now_ns));
  const PipelineStatistics& statistics = running.pipeline.statistics();
  json["frames"] = counts_json(can::frame_verdict_names, statistics.frames);
  json["stamps"] = counts_json(can::stamp_verdict_names, statistics.stamps);
  for (std::size_t i = 0; i < estimator::source_count; ++i)
    json["sources"].push_back(source_json(i, running, published, now_ns));
  json["camera"] = camera_json(running);
  json["clock"] = clock_json(running);
  json["realtime"] = realtime_json(running.machine, running.beat_thread);
  json["events_dropped"] = running.events.dropped();
  return json.dump(-1, ' ', true, Json::error_handler_t::replace) + '\n';
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
