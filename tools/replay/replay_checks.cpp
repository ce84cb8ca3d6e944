#include "tools/replay/replay_checks.hpp"

#include <algorithm>
#include <cstddef>
#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include <fmt/format.h>
#include <fmt/ranges.h>
#include <nlohmann/json.hpp>

#include "daemon/core/conditions.hpp"
#include "estimator/common/measurement.hpp"
#include "tools/cli/csv.hpp"
#include "tools/diagnostics/kinds.hpp"
#include "tools/diagnostics/output.hpp"
#include "tools/drive_files/pose_csv.hpp"

namespace odomd::tools {
namespace {

using can::FrameVerdict;
using diagnostics::Diagnostic;
using diagnostics::found;

std::string roles(const can::BoundMessage& message) {
  std::vector<std::string_view> names;
  for (const std::uint16_t channel : message.channels)
    names.push_back(estimator::source_names.at(channel));
  return fmt::format("{}", fmt::join(names, ", "));
}

std::string named(const can::BoundMessage& message) {
  return fmt::format("message '{}' ({})", message.name, roles(message));
}

std::uint64_t count(const can::MessageCounters& counters, FrameVerdict verdict) {
  return counters.verdicts[static_cast<std::size_t>(verdict)].get();
}

// A frame whose payload is cut off in the log reads like a shorter frame.
std::optional<Diagnostic> cut_frames(const can::BoundMessage& message,
                                     const can::MessageCounters& counters) {
  const std::uint64_t cut = count(counters, FrameVerdict::too_short);
  if (cut == 0 || count(counters, FrameVerdict::decoded) == 0) return std::nullopt;
  return found(kind("frames_cut_off"), named(message),
               fmt::format("{} of its frames ended before its signals and gave no value", cut));
}

}  // namespace

std::optional<Diagnostic> check_mode(const ReplaySummary& summary) {
  if (!summary.fault_ns) return std::nullopt;
  std::string t;
  append_seconds(t, *summary.fault_ns);
  std::string why;
  for (const daemon::Condition& condition : daemon::conditions_in(summary.fault_conditions))
    why += fmt::format("{}{}: {}", why.empty() ? "" : "; ", condition.name, condition.meaning);
  const double into = static_cast<double>(*summary.fault_ns - summary.first_tick_ns) * 1e-9;
  return found(
      kind("model_fault"), {},
      fmt::format("the mode is fault from t = {}, {:.3f} s into the drive, for {} of {} ticks: do "
                  "not rely on those poses ({})",
                  t, into, summary.faulty, summary.ticks,
                  why.empty() ? "no condition says why" : why));
}

std::optional<Diagnostic> check_message(const can::BoundMessage& message,
                                        const can::MessageCounters& counters) {
  if (count(counters, FrameVerdict::decoded) > 0) return std::nullopt;
  const std::uint64_t refused =
      count(counters, FrameVerdict::failed_crc) + count(counters, FrameVerdict::repeated) +
      count(counters, FrameVerdict::wrong_sequence) + count(counters, FrameVerdict::distrusted);
  const std::uint64_t empty = count(counters, FrameVerdict::no_sample);
  const std::uint64_t cut = count(counters, FrameVerdict::too_short);
  if (refused + empty + cut == 0)
    return found(kind("message_missing"), named(message), "no frame of it is in the log");
  return found(kind("message_without_value"), named(message),
               fmt::format("none of its {} frames gave a value: {} failed their protection, {} are "
                           "too short, {} carry none (valid_when, multiplexing)",
                           refused + empty + cut, refused, cut, empty));
}

diagnostics::Diagnostics check_replay(const can::Decoder& decoder, const ReplaySummary& summary) {
  diagnostics::Diagnostics warnings;
  const auto messages = decoder.messages();
  const bool none_came = std::ranges::all_of(messages, [&](const can::BoundMessage& message) {
    const auto& verdicts =
        decoder.counters(static_cast<std::size_t>(&message - messages.data())).verdicts;
    return std::ranges::all_of(verdicts, [](const auto& count) { return count.get() == 0; });
  });
  const std::uint64_t frames = summary.frames + summary.unmapped;
  if (none_came && frames > 0)
    warnings.push_back(
        found(kind("other_database"), {},
              fmt::format("none of the {} mapped messages is among the {} frames of the log",
                          messages.size(), frames)));
  for (std::size_t i = 0; i < messages.size() && !none_came; ++i) {
    append(warnings, check_message(messages[i], decoder.counters(i)));
    append(warnings, cut_frames(messages[i], decoder.counters(i)));
  }
  if (summary.late > 0)
    warnings.push_back(found(
        kind("frames_late"), {},
        fmt::format(
            "{}{} frames have stamps {:g} s or more earlier than "
            "frames before them",
            2 * summary.late > summary.frames ? "the log is in reverse, which tac undoes: " : "",
            summary.late, kind("frames_late").limits.most)));
  const std::uint64_t camera_poses = summary.cameras + summary.cameras_after;
  if (camera_poses > 0 && camera_poses == summary.cameras_before + summary.cameras_after)
    warnings.push_back(found(
        kind("camera_outside_log"), "camera",
        fmt::format("none of the {} camera poses arrives while the log lasts", camera_poses)));
  diagnostics::Diagnostics of_sources = check_sources(decoder, summary);
  if (!warnings.empty() && warnings.back().kind == &kind("camera_outside_log"))
    std::erase_if(of_sources, [](const Diagnostic& one) {
      return one.kind == &kind("source_unused") && one.subject == "camera";
    });
  append(warnings, of_sources);
  append(warnings, check_mode(summary));
  if (summary.poses == 0)
    warnings.push_back(
        found(kind("no_pose"), {}, "no pose: the car's motion or its start is unknown"));
  return warnings;
}

// The result of a replay as JSON.
namespace {

using Json = nlohmann::ordered_json;

/// An object with the values of all sources that have a value.
template <typename ValueOf>
Json by_source(const ValueOf& value_of) {
  Json sources = Json::object();
  for (std::size_t source = 0; source < estimator::source_count; ++source)
    if (Json value = value_of(source); !value.empty())
      sources[std::string{estimator::source_names[source]}] = std::move(value);
  return sources;
}

// For how long [s] each source had a wiring fault or was inconsistent.
Json wiring_json(const ReplaySummary& summary) {
  const double tick_s = static_cast<double>(summary.last_tick_ns - summary.first_tick_ns) * 1e-9 /
                        static_cast<double>(std::max<std::uint64_t>(summary.ticks, 1));
  return by_source([&](std::size_t source) {
    Json faults;
    for (std::size_t fault = 1; fault < daemon::wiring_names.size(); ++fault)
      if (const std::uint64_t ticks = summary.wired[source][fault]; ticks > 0)
        faults[std::string{daemon::wiring_names[fault]}] = tick_s * static_cast<double>(ticks);
    if (const std::uint64_t ticks = summary.inconsistent[source]; ticks > 0)
      faults["inconsistent"] = tick_s * static_cast<double>(ticks);
    return faults;
  });
}

/// The stated sigma and the filter's estimates at the end (null: none), for each source that has an
/// estimate.
Json noise_json(const ReplaySummary& summary) {
  const auto or_null = [](double value) { return value > 0.0 ? Json(value) : Json(); };
  return by_source([&](std::size_t source) -> Json {
    const estimator::SourceNoise& estimate = summary.noise[source];
    if (!estimate.estimated()) return {};
    return {{"sigma", estimate.stated},
            {"at_rest", or_null(estimate.at_rest)},
            {"moving", or_null(estimate.moving)},
            {"speed_share", or_null(estimate.speed_share)}};
  });
}

}  // namespace

Json innovations_json(const ReplaySummary& summary) {
  return by_source([&](std::size_t source) -> Json {
    const daemon::InnovationStatistics& statistics = summary.innovations[source];
    if (statistics.count == 0) return {};
    return {{"count", statistics.count},
            {"gated", statistics.gated},
            {"dimension", statistics.dimension},
            {"mean_nis", statistics.mean_nis()},
            {"inside_95", statistics.inside_95()}};
  });
}

Json verdicts_json(const ReplaySummary& summary) {
  return by_source([&](std::size_t source) {
    Json verdicts;
    for (std::size_t verdict = 0; verdict < estimator::verdict_count; ++verdict)
      if (const std::uint64_t count = summary.verdicts[source][verdict]; count > 0)
        verdicts[std::string{estimator::verdict_names[verdict]}] = count;
    return verdicts;
  });
}

Json replay_json(const ReplaySummary& summary, double seconds,
                 const diagnostics::Diagnostics& warnings) {
  return {
      {"frames", summary.frames},
      {"camera_poses", summary.cameras},
      {"ticks", summary.ticks},
      {"poses", summary.poses},
      {"drive_s", static_cast<double>(summary.last_tick_ns - summary.first_tick_ns) * 1e-9},
      {"replay_s", seconds},
      {"last_mode", mode_name(summary.last_mode)},
      {"verdicts", verdicts_json(summary)},
      {"innovations", innovations_json(summary)},
      {"noise", noise_json(summary)},
      {"wiring", wiring_json(summary)},
      {"warnings", texts_of(warnings)},
      {"diagnostics", as_json(warnings)},
  };
}

}  // namespace odomd::tools
