#include "tools/doctor/doctor.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <string>
#include <vector>

#include "tools/diagnostics/kinds.hpp"

namespace odomd::tools::doctor {
namespace {

using diagnostics::Diagnostic;
using diagnostics::Diagnostics;
using diagnostics::found;
using estimator::Source;

constexpr const diagnostics::Kind& off_kind = kind("latency_off");
constexpr double max_sigmas = 3.0;  // standard uncertainties
constexpr double max_sigma =
    0.005;  // standard uncertainty [s]; less certain offsets are not judged
constexpr double max_sigma_of_steering = 0.02;

bool is_steering(const SourceOffset& one) {
  return one.source == Source::steering;
}

// The steering is off only if the wheels respond earlier than [steering] says: if they respond
// later, the actuator may be slower.
bool is_off(const SourceOffset& one) {
  if (is_steering(one)) return one.offset > max_sigmas * one.sigma;
  return !off_kind.limits.hold(std::fabs(one.offset) - max_sigmas * one.sigma);
}

bool is_judged(const SourceOffset& one) {
  return one.failure.empty() && one.sigma < (is_steering(one) ? max_sigma_of_steering : max_sigma);
}

// The signals of one message are sampled together: if not all are late, the estimate is wrong.
bool is_late_as_a_whole(const daemon::Config& config, const SourceOffset& one,
                        std::span<const SourceOffset> offsets) {
  const can::SignalBinding* const own = binding_of(config, one.source);
  return std::ranges::all_of(offsets, [&](const SourceOffset& other) {
    const can::SignalBinding* const binding = binding_of(config, other.source);
    const bool together = own != nullptr && binding != nullptr && binding->message == own->message;
    return !together || (is_judged(other) && is_off(other));
  });
}

std::string late(double seconds) {
  return fmt::format("{:.0f} ms {}", 1e3 * std::fabs(seconds), seconds > 0.0 ? "late" : "early");
}

// `offset`: delay of the source's stamps behind those of other sources [s].
Diagnostic of_sensor(const daemon::Config& config, Source source, double offset) {
  const double stated = configured_latency(config, source);
  return found(
      off_kind, name_of(source),
      fmt::format("its samples are {}{} compared with the others{}; the latency stated is "
                  "{:.3f} s",
                  source == Source::steering ? "at least " : "", late(offset),
                  source == Source::steering ? ", or [steering] delay and lag are too long" : "",
                  stated),
      fmt::format("can.signals.{}.latency = {:.3f}", name_of(source),
                  std::max(stated + offset, 0.0)));
}

/// Whether equal offsets of all other sources are the gyro's fault: either sensors of several kinds
/// agree, or otherwise the latencies of the others would be negative.
bool is_fault_of_gyro(const daemon::Config& config, std::span<const SourceOffset> judged,
                      double offset) {
  // All sources but the camera count as one kind: wheels are measured by the difference of an axle.
  const auto is_camera = [](const SourceOffset& one) { return one.source == Source::camera; };
  if (std::ranges::any_of(judged, is_camera) && !std::ranges::all_of(judged, is_camera))
    return true;
  if (offset > 0.0)
    return off_kind.limits.hold(offset - configured_latency(config, Source::yaw_rate));
  return std::ranges::any_of(judged, [&](const SourceOffset& one) {
    return !off_kind.limits.hold(-one.offset - configured_latency(config, one.source));
  });
}

}  // namespace

std::string latencies_unjudged(std::span<const SourceOffset> offsets) {
  std::map<std::string, std::vector<std::string>> names;  // by reason
  for (const SourceOffset& one : offsets)
    if (!is_judged(one))
      names[one.failure.empty() ? "too little driving" : one.failure].emplace_back(
          name_of(one.source));
  std::string text;
  for (const auto& [reason, sources] : names)
    text += fmt::format("{}latency of {} not judged: {}", text.empty() ? "" : "; ",
                        fmt::join(sources, ", "), reason);
  return text;
}

Diagnostics examine_latencies(const daemon::Config& config, std::span<const SourceOffset> offsets) {
  std::vector<SourceOffset> judged;
  std::ranges::copy_if(offsets, std::back_inserter(judged), is_judged);
  if (std::ranges::none_of(judged, is_off)) return {};
  std::vector<SourceOffset> sensors = judged;  // without the steering
  std::erase_if(sensors, is_steering);
  if (!sensors.empty() && std::ranges::all_of(sensors, is_off)) {
    const auto [least, most] = std::ranges::minmax(sensors, {}, &SourceOffset::offset);
    const double mean = 0.5 * (least.offset + most.offset);
    if (off_kind.limits.hold(most.offset - least.offset) && is_fault_of_gyro(config, sensors, mean))
      return {of_sensor(config, Source::yaw_rate, -mean)};
  }
  Diagnostics all;
  for (const SourceOffset& one : judged) {
    if (!is_off(one) || !is_late_as_a_whole(config, one, offsets)) continue;
    if (one.source == Source::camera)
      all.push_back(found(kind("clocks_differ"), name_of(one.source),
                          "its times are " + late(one.offset) + " compared with the gyro's"));
    else
      all.push_back(of_sensor(config, one.source, one.offset));
  }
  return all;
}

}  // namespace odomd::tools::doctor
