#include "tools/replay/replay_checks.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <numeric>
#include <optional>
#include <utility>

#include "daemon/core/source_diagnostics.hpp"
#include "daemon/diagnostics/diagnostic.hpp"
#include "estimator/common/measurement.hpp"

namespace odomd::tools {
namespace {

using estimator::Source;
using estimator::SourceFlag;
using estimator::Verdict;

constexpr double long_flagged_s = 1.0;
constexpr double long_part = 0.1;  // share of a drive under 10 s
constexpr std::uint64_t min_judged = 10;

// All flags but slipping, which is temporary, and missing signals, which the mode shows.
constexpr std::array reported_flags{SourceFlag::out_of_range, SourceFlag::non_finite,
                                    SourceFlag::frozen, SourceFlag::drifting,
                                    SourceFlag::failed_protection};

const can::BoundMessage* message_of(const can::Decoder& decoder, std::size_t source) {
  const auto found = std::ranges::find_if(decoder.messages(), [&](const auto& message) {
    return std::ranges::find(message.channels, source) != message.channels.end();
  });
  return found == decoder.messages().end() ? nullptr : &*found;
}

// "yaw_rate (IMU)", "camera".
std::string label(const can::Decoder& decoder, std::size_t source) {
  const std::string_view name = estimator::source_names[source];
  const can::BoundMessage* const message = message_of(decoder, source);
  return message == nullptr ? std::string(name) : fmt::format("{} ({})", name, message->name);
}

double drive_seconds(const ReplaySummary& summary) {
  return static_cast<double>(summary.last_tick_ns - summary.first_tick_ns) * 1e-9;
}

// `count` ticks as a share of the drive.
double share(const ReplaySummary& summary, std::uint64_t count) {
  return static_cast<double>(count) /
         static_cast<double>(std::max<std::uint64_t>(summary.ticks, 1));
}

// Whether `count` ticks are long enough to report.
bool is_long(const ReplaySummary& summary, std::uint64_t count) {
  const double drive_s = drive_seconds(summary);
  return count > 0 &&
         share(summary, count) * drive_s >= std::min(long_flagged_s, long_part * drive_s);
}

// The duration of `count` ticks.
std::string for_seconds(const ReplaySummary& summary, std::uint64_t count) {
  const double drive_s = drive_seconds(summary);
  return fmt::format(" (for {:.1f} of {:.1f} s)", share(summary, count) * drive_s, drive_s);
}

// Adds a diagnostic with the duration of the `count` ticks in which it applied, if there is one.
void add(diagnostics::Diagnostics& warnings, std::optional<diagnostics::Diagnostic> warning,
         const ReplaySummary& summary, std::uint64_t count) {
  if (!warning) return;
  warning->seen += for_seconds(summary, count);
  append(warnings, std::move(warning));
}

// Gives one diagnostic per wiring fault: sources with equal durations share one fault.
void warn_of_wiring(const can::Decoder& decoder, const ReplaySummary& summary,
                    diagnostics::Diagnostics& warnings) {
  for (std::size_t fault = 1; fault < daemon::wiring_names.size(); ++fault) {
    for (std::size_t source = 0; source < estimator::source_count; ++source) {
      const auto count_of = [&](std::size_t of) { return summary.wired[of][fault]; };
      const std::uint64_t count = count_of(source);
      if (static_cast<Source>(source) == Source::camera && !summary.camera_units.empty()) continue;
      std::string who;
      bool reported_already = false;
      for (std::size_t other = 0; other < estimator::source_count; ++other) {
        if (count_of(other) != count) continue;
        reported_already |= other < source;
        who += (who.empty() ? "" : ", ") + label(decoder, other);
      }
      if (count == 0 || reported_already) continue;
      add(warnings,
          daemon::diagnostic_of(static_cast<daemon::WiringFault>(fault),
                                estimator::source_names[source], who),
          summary, count);
    }
  }
}

std::string_view what_to_check(Source source) {
  if (source == Source::camera)
    return "that its poses are of this drive and this map, its clock and its sigmas";
  return is_inertial(source) ? "its unit, sign, scale, offset and mounting"
                             : "its unit, scale and sign, and the vehicle";
}

// How to fix samples that were not used. Gated samples have their own diagnostic (often_gated).
std::string fix_for(const ReplaySummary& summary, Source source, Verdict verdict) {
  switch (verdict) {
    case Verdict::too_old:
      if (source == Source::camera)
        return fmt::format(
            "raise camera.max_latency, and filter.window with it, above {:.3f} s, the median age "
            "of its poses at their arrival",
            summary.camera_delay_s);
      return fmt::format(
          "check can.signals.{}.latency, which filter.window must cover, and that all buses have "
          "one clock",
          estimator::source_names[estimator::index_of(source)]);
    case Verdict::future:
      return "put its times on the log's clock";
    case Verdict::duplicate:
      return "give each sample its own time";
    case Verdict::failed_protection:
      return "check [can.e2e]";
    default:
      return fmt::format("check {}", what_to_check(source));
  }
}

// Reports refused samples, or the time without samples. A message without a value is reported by
// check_message().
std::optional<diagnostics::Diagnostic> unused(const can::Decoder& decoder,
                                              const ReplaySummary& summary, std::size_t source) {
  constexpr const diagnostics::Kind& kind = diagnostics::kind("source_unused");
  const auto& verdicts = summary.verdicts[source];
  const auto count = [&](Verdict verdict) { return verdicts[static_cast<std::size_t>(verdict)]; };
  const std::uint64_t all = std::accumulate(verdicts.begin(), verdicts.end(), std::uint64_t{0}) -
                            count(Verdict::source_off);
  const auto is_reported = [&](Verdict verdict) {
    const SourceFlag flag = verdict == Verdict::non_finite          ? SourceFlag::non_finite
                            : verdict == Verdict::failed_protection ? SourceFlag::failed_protection
                                                                    : SourceFlag::ok;
    return flag != SourceFlag::ok &&
           is_long(summary, summary.flagged[source][static_cast<std::size_t>(flag)]);
  };
  std::uint64_t refused = 0;
  Verdict most = Verdict::gated;
  std::string why;
  for (const Verdict verdict : {Verdict::too_old, Verdict::future, Verdict::duplicate,
                                Verdict::non_finite, Verdict::failed_protection}) {
    if (count(verdict) == 0 || is_reported(verdict)) continue;
    refused += count(verdict);
    if (most == Verdict::gated || count(verdict) > count(most)) most = verdict;
    why += fmt::format("{}{} {}", why.empty() ? "" : ", ", count(verdict),
                       estimator::verdict_names[static_cast<std::size_t>(verdict)]);
  }
  if (refused > 0 && !kind.limits.hold(static_cast<double>(refused) / static_cast<double>(all)))
    return found(kind, label(decoder, source),
                 fmt::format("{} of its {} samples were not used: {}",
                             refused == all ? "all" : std::to_string(refused), all, why),
                 fix_for(summary, static_cast<Source>(source), most));
  const can::BoundMessage* message = message_of(decoder, source);
  if (message == nullptr) return std::nullopt;
  const auto index = static_cast<std::size_t>(message - decoder.messages().data());
  if (decoder.counters(index)
          .verdicts[static_cast<std::size_t>(can::FrameVerdict::decoded)]
          .get() == 0)
    return std::nullopt;
  const std::uint64_t silent =
      summary.flagged[source][static_cast<std::size_t>(SourceFlag::timed_out)];
  if (kind.limits.hold(share(summary, silent))) return std::nullopt;
  return found(kind, label(decoder, source),
               "it gave no value in its timeout" + for_seconds(summary, silent),
               fmt::format("check the rate of its frames, and can.signals.{0}: valid_when, timeout",
                           estimator::source_names[source]));
}

bool is_miswired(const ReplaySummary& summary, std::size_t source) {
  return std::any_of(summary.wired[source].begin() + 1, summary.wired[source].end(),
                     [](std::uint64_t ticks) { return ticks > 0; });
}

}  // namespace

std::optional<diagnostics::Diagnostic> check_gating(Source source, const std::string& label,
                                                    std::uint64_t gated, std::uint64_t judged) {
  constexpr const diagnostics::Kind& often_gated = diagnostics::kind("often_gated");
  const double part = static_cast<double>(gated) / static_cast<double>(judged);
  if (judged < min_judged || often_gated.limits.hold(part)) return std::nullopt;
  return found(often_gated, label,
               fmt::format("{} of its {} samples ({:.0f} %) were gated: they differ too much from "
                           "the filter's prediction",
                           gated, judged, 100.0 * part),
               std::string{what_to_check(source)});
}

diagnostics::Diagnostics check_sources(const can::Decoder& decoder, const ReplaySummary& summary) {
  // If the camera's units are wrong, its other findings follow from that.
  diagnostics::Diagnostics warnings = summary.camera_units;
  warn_of_wiring(decoder, summary, warnings);
  if (is_long(summary, summary.bias_unlearnt))
    add(warnings, daemon::unlearnt_bias(), summary, summary.bias_unlearnt);
  if (is_long(summary, summary.scale_implausible))
    add(warnings, daemon::implausible_scale(), summary, summary.scale_implausible);
  for (std::size_t source = 0; source < estimator::source_count; ++source) {
    if (static_cast<Source>(source) == Source::camera && !summary.camera_units.empty()) continue;
    const bool miswired = is_miswired(summary, source);
    if (const std::uint64_t count = summary.inconsistent[source]; count > 0 && !miswired)
      add(warnings, daemon::inconsistent_source(label(decoder, source)), summary, count);
    bool explained = miswired;  // why samples are gated
    for (const SourceFlag flag : reported_flags) {
      if (miswired && flag == SourceFlag::drifting) continue;
      const std::uint64_t count = summary.flagged[source][static_cast<std::size_t>(flag)];
      if (!is_long(summary, count)) continue;
      explained |= flag == SourceFlag::frozen || flag == SourceFlag::out_of_range;
      add(warnings, daemon::diagnostic_of(flag, label(decoder, source)), summary, count);
    }
    append(warnings, unused(decoder, summary, source));
    const auto& verdicts = summary.verdicts[source];
    const std::uint64_t gated = verdicts[static_cast<std::size_t>(Verdict::gated)];
    const std::uint64_t fused = verdicts[static_cast<std::size_t>(Verdict::fused)];
    if (!explained)
      append(warnings, check_gating(static_cast<Source>(source), label(decoder, source), gated,
                                    gated + fused));
  }
  return warnings;
}

}  // namespace odomd::tools
