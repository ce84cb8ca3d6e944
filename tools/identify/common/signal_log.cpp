#include "tools/identify/common/signal_log.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <stdexcept>

#include "can_protocol/bus_names.hpp"
#include "can_protocol/decode/decoder.hpp"
#include "can_protocol/sources/log_reader.hpp"
#include "can_protocol/sources/stamp_guard.hpp"
#include "daemon/core/imu_mounting.hpp"
#include "daemon/diagnostics/diagnostic.hpp"
#include "tools/cli/text.hpp"
#include "tools/diagnostics/log_order.hpp"
#include "tools/replay/replay_checks.hpp"

namespace odomd::tools {
namespace {

bool is_good(const can::Sample& sample, const Series& series) {
  return std::isfinite(sample.value) && (series.empty() || sample.time_ns > series.t_ns.back());
}

}  // namespace

const can::SignalBinding* binding_of(const daemon::Config& config, estimator::Source source) {
  const auto found = std::ranges::find(config.can.bindings, estimator::index_of(source),
                                       &can::SignalBinding::channel);
  return found == config.can.bindings.end() ? nullptr : &*found;
}

Series with_direction(Series speed, const Series& gear) {
  std::size_t g = 0;
  for (std::size_t i = 0; i < speed.size() && !gear.empty(); ++i) {
    while (g + 1 < gear.size() && gear.t_ns[g + 1] <= speed.t_ns[i]) ++g;
    if (gear.value[g] < 0.0) speed.value[i] = -std::fabs(speed.value[i]);
  }
  return speed;
}

std::vector<PoseSample> in_order(std::span<const estimator::CameraPose> poses,
                                 std::int64_t origin_ns) {
  std::vector<estimator::CameraPose> seen(poses.begin(), poses.end());
  std::ranges::stable_sort(seen, {}, &estimator::CameraPose::capture_ns);
  std::vector<PoseSample> result;
  double yaw = seen.empty() ? 0.0 : seen.front().yaw;
  for (const estimator::CameraPose& pose : seen) {
    const double t = 1e-9 * static_cast<double>(pose.capture_ns - origin_ns);
    if (!result.empty() && t <= result.back().t) continue;
    yaw += std::remainder(pose.yaw - yaw, 2.0 * std::numbers::pi);
    result.push_back({t, pose.x, pose.y, yaw, pose.sigma_x, pose.sigma_y, pose.sigma_yaw});
  }
  return result;
}

const Series& SignalLog::need(estimator::Source source) const {
  const Series& series = of(source);
  if (has(source)) return series;
  const std::string& why = why_empty.at(estimator::index_of(source));
  throw std::invalid_argument(fmt::format(
      "{}: has {} {}: {}", name, series.empty() ? "no" : "a single sample of", name_of(source),
      !series.empty() ? "log it completely"
      : why.empty()   ? "it is mapped to no signal; map it in [can.signals]"
                      : why));
}

SignalLog read_signals(daemon::Config config, std::span<const std::string> logs) {
  SignalLog result;
  const std::vector<can::Database> databases = daemon::load_databases(config, result.warnings);
  can::BusNames buses;
  for (const std::string& bus : daemon::expected_buses(config)) buses.index_of(bus);
  can::MergedLog log(logs, buses);
  can::Decoder decoder(databases, config.can.bindings, config.can.protections, buses.all());

  LogOrder order;
  can::StampGuard guard;
  std::array<can::Sample, can::max_samples_per_frame> samples;
  std::uint64_t frames = 0;
  std::uint64_t left_out = 0;
  while (const can::Frame* frame = log.next()) {
    if (frame->kind == can::FrameKind::error) continue;
    order.take(frame->time_ns, [&log] { return log.position(); });
    if (frames++ == 0) result.first_ns = frame->time_ns;
    result.last_ns = std::max(result.last_ns, frame->time_ns);
    const can::StampVerdict stamp = guard.check(*frame, frame->time_ns);
    const can::DecodeResult decoded = decoder.decode(*frame, samples);
    const std::span<can::Sample> taken(samples.data(), decoded.count);
    if (config.imu_yaw != 0.0) daemon::turn_accelerations(taken, config.imu_yaw);
    for (const can::Sample& sample : taken) {
      Series& series = result.signals[sample.channel];
      if (stamp != can::StampVerdict::trusted || !is_good(sample, series)) {
        ++left_out;
        continue;
      }
      series.t_ns.push_back(sample.time_ns);
      series.value.push_back(sample.value);
    }
  }
  order.require_sorted();
  result.name = can::log_label(logs.front());
  for (std::size_t i = 0; i < decoder.messages().size(); ++i)
    if (const auto warning = check_message(decoder.messages()[i], decoder.counters(i)))
      for (const std::uint16_t channel : decoder.messages()[i].channels)
        result.why_empty.at(channel) = text_of(*warning);
  append(result.warnings, diagnostics::kind("log_content"), log.warnings());
  if (left_out > 0) {
    result.warnings.push_back(
        found(diagnostics::kind("log_content"), logs.front(),
              fmt::format("{} without a time of {} own, or not finite, left out",
                          counted(left_out, "sample"), left_out == 1 ? "its" : "their")));
  }
  return result;
}

}  // namespace odomd::tools
