#include "tools/replay/source_doubts.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>

#include "daemon/core/source_complaint.hpp"
#include "estimator/common/measurement.hpp"
#include "estimator/integrity/integrity.hpp"

namespace odomd::tools {
namespace {

using estimator::Source;
using estimator::SourceFlag;
using estimator::Verdict;

constexpr double long_flagged_s = 1.0;
constexpr double long_part = 0.1;  // of a shorter drive
constexpr double large_part_gated = 0.25;
constexpr std::uint64_t least_samples = 10;

// Wheels slip and grip again, and a drive without a signal for a while has the mode to say so.
constexpr std::array told{SourceFlag::out_of_range, SourceFlag::non_finite, SourceFlag::frozen,
                          SourceFlag::drifting, SourceFlag::failed_protection};

std::string complaint(SourceFlag flag) {
  return flag == SourceFlag::failed_protection
             ? " fails its protection: look at [can.e2e] and its message's counts in odom status"
             : std::string{daemon::complaint(flag)};
}

// "yaw_rate (IMU)", "camera".
std::string label(const can::Decoder& decoder, std::size_t source) {
  for (const can::BoundMessage& message : decoder.messages())
    if (std::ranges::find(message.channels, source) != message.channels.end())
      return fmt::format("{} ({})", estimator::source_names[source], message.name);
  return std::string{estimator::source_names[source]};
}

std::string_view what_to_look_at(Source source) {
  switch (source) {
    case Source::camera:
      return "look at whether its poses are of this drive and this map, at its clock and its "
             "sigmas";
    case Source::yaw_rate:
    case Source::accel_x:
    case Source::accel_y:
      return "look at its unit, sign, scale, offset and mounting";
    default:
      return "look at its unit, scale and sign, and at the vehicle";
  }
}

// Seconds of so many ticks.
std::string seconds(const ReplaySummary& summary, std::uint64_t count) {
  const double drive_s = static_cast<double>(summary.last_tick_ns - summary.first_tick_ns) * 1e-9;
  const auto ticks = static_cast<double>(std::max<std::uint64_t>(summary.ticks, 1));
  return fmt::format(" (for {:.1f} of {:.1f} s)", static_cast<double>(count) / ticks * drive_s,
                     drive_s);
}

// One line a mistake: that of several sources is of one if it was named for as long.
void say_wiring(const can::Decoder& decoder, const ReplaySummary& summary,
                std::vector<std::string>& doubts) {
  for (std::size_t fault = 1; fault < daemon::wiring_names.size(); ++fault) {
    for (std::size_t source = 0; source < estimator::source_count; ++source) {
      const auto count_of = [&](std::size_t of) { return summary.wired[of][fault]; };
      const std::uint64_t count = count_of(source);
      if (static_cast<Source>(source) == Source::camera && !summary.camera_units.empty()) continue;
      std::string who;
      bool told_already = false;
      for (std::size_t other = 0; other < estimator::source_count; ++other) {
        if (count_of(other) != count) continue;
        told_already |= other < source;
        who += (who.empty() ? "" : ", ") + label(decoder, other);
      }
      if (count == 0 || told_already) continue;
      doubts.push_back(who +
                       daemon::complaint(static_cast<daemon::WiringFault>(fault),
                                         estimator::source_names[source]) +
                       seconds(summary, count));
    }
  }
}

bool is_miswired(const ReplaySummary& summary, std::size_t source) {
  return std::any_of(summary.wired[source].begin() + 1, summary.wired[source].end(),
                     [](std::uint64_t ticks) { return ticks > 0; });
}

}  // namespace

std::vector<std::string> source_doubts(const can::Decoder& decoder, const ReplaySummary& summary) {
  std::vector<std::string> doubts;
  // All else that there is to say of the camera comes of this, and of others some.
  if (!summary.camera_units.empty()) doubts.push_back("camera: " + summary.camera_units);
  say_wiring(decoder, summary, doubts);
  const auto ticks = static_cast<double>(std::max<std::uint64_t>(summary.ticks, 1));
  const double drive_s = static_cast<double>(summary.last_tick_ns - summary.first_tick_ns) * 1e-9;
  for (std::size_t source = 0; source < estimator::source_count; ++source) {
    if (static_cast<Source>(source) == Source::camera && !summary.camera_units.empty()) continue;
    const bool miswired = is_miswired(summary, source);
    if (const std::uint64_t count = summary.inconsistent[source]; count > 0 && !miswired)
      doubts.push_back(label(decoder, source) + std::string{daemon::inconsistent_complaint} +
                       seconds(summary, count));
    for (const SourceFlag flag : told) {
      if (miswired && flag == SourceFlag::drifting) continue;
      const double part =
          static_cast<double>(summary.flagged[source][static_cast<std::size_t>(flag)]) / ticks;
      if (part <= 0.0 || part * drive_s < std::min(long_flagged_s, long_part * drive_s)) continue;
      doubts.push_back(label(decoder, source) + complaint(flag) +
                       seconds(summary, summary.flagged[source][static_cast<std::size_t>(flag)]));
    }
    const auto& verdicts = summary.verdicts[source];
    const std::uint64_t gated = verdicts[static_cast<std::size_t>(Verdict::gated)];
    const std::uint64_t judged = gated + verdicts[static_cast<std::size_t>(Verdict::fused)];
    const double part =
        static_cast<double>(gated) / static_cast<double>(std::max(judged, least_samples));
    if (miswired || judged < least_samples || part <= large_part_gated) continue;
    doubts.push_back(fmt::format(
        "{}: {} of its {} samples ({:.0f} %) were gated, too far from what the others made the "
        "filter expect: {}",
        label(decoder, source), gated, judged, 100.0 * part,
        what_to_look_at(static_cast<Source>(source))));
  }
  return doubts;
}

}  // namespace odomd::tools
