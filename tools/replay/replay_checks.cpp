#include "tools/replay/replay_checks.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <cstddef>
#include <optional>
#include <string_view>
#include <utility>

#include "estimator/common/measurement.hpp"
#include "tools/cli/csv.hpp"
#include "tools/diagnostics/conditions.hpp"
#include "tools/replay/source_checks.hpp"

namespace odomd::tools {
namespace {

using can::FrameVerdict;

std::string roles(const can::BoundMessage& message) {
  std::vector<std::string_view> names;
  for (const std::uint16_t channel : message.channels)
    names.push_back(estimator::source_names.at(channel));
  return fmt::format("{}", fmt::join(names, ", "));
}

// A frame that is cut off in its middle reads like a short one.
std::optional<std::string> cut_frames(const can::BoundMessage& message,
                                      const can::MessageCounters& counters) {
  const auto count = [&](FrameVerdict verdict) {
    return counters.verdicts[static_cast<std::size_t>(verdict)].get();
  };
  const std::uint64_t cut = count(FrameVerdict::too_short);
  if (cut == 0 || count(FrameVerdict::decoded) == 0) return std::nullopt;
  return fmt::format(
      "message '{}' ({}): {} of its frames ended before its signals and gave no value: check "
      "whether the log is cut off in the middle of a line",
      message.name, roles(message), cut);
}

// "mode fault from t = 12.345000000 on (2.345 s into the drive, ...)".
std::string fault(const ReplaySummary& summary) {
  std::string t;
  append_seconds(t, *summary.fault_ns);
  std::string why;
  for (const Condition& condition : conditions_in(summary.fault_conditions))
    why += fmt::format("{}{}: {}", why.empty() ? "" : "; ", condition.name, condition.meaning);
  const double into = static_cast<double>(*summary.fault_ns - summary.first_tick_ns) * 1e-9;
  return fmt::format(
      "the mode is fault from t = {}, {:.3f} s into the drive, for {} of {} ticks: do not rely on "
      "those poses ({}); check the signals' scales and signs, the vehicle, and that the databases "
      "are this car's",
      t, into, summary.faulty, summary.ticks, why.empty() ? "no condition says why" : why);
}

}  // namespace

std::optional<std::string> message_warning(const can::BoundMessage& message,
                                           const can::MessageCounters& counters) {
  const auto count = [&](FrameVerdict verdict) {
    return counters.verdicts[static_cast<std::size_t>(verdict)].get();
  };
  if (count(FrameVerdict::decoded) > 0) return std::nullopt;
  const auto start = fmt::format("message '{}' ({}): ", message.name, roles(message));
  const std::uint64_t refused = count(FrameVerdict::failed_crc) + count(FrameVerdict::repeated) +
                                count(FrameVerdict::wrong_sequence) +
                                count(FrameVerdict::distrusted);
  const std::uint64_t empty = count(FrameVerdict::no_sample);
  const std::uint64_t cut = count(FrameVerdict::too_short);
  if (refused + empty + cut == 0)
    return start + "no frame of it is in the log; its values are missing";
  return fmt::format(
      "{}none of its {} frames gave a value: {} failed their protection ([can.e2e]), {} are too "
      "short, {} carry none (valid_when, multiplexing)",
      start, refused + empty + cut, refused, cut, empty);
}

std::vector<std::string> replay_warnings(const can::Decoder& decoder,
                                         const ReplaySummary& summary) {
  std::vector<std::string> warnings;
  const auto messages = decoder.messages();
  for (std::size_t i = 0; i < messages.size(); ++i) {
    if (auto warning = message_warning(messages[i], decoder.counters(i)))
      warnings.push_back(*warning);
    if (auto warning = cut_frames(messages[i], decoder.counters(i))) warnings.push_back(*warning);
  }
  if (summary.late > 0)
    warnings.push_back(
        fmt::format("{} frames have stamps a second or more earlier than frames before them; sort "
                    "the log, or cut it where its clock was set back",
                    summary.late));
  const std::uint64_t camera_poses = summary.cameras + summary.cameras_after;
  if (camera_poses > 0 && camera_poses == summary.cameras_before + summary.cameras_after)
    warnings.push_back(fmt::format(
        "none of the {} camera poses arrives while the log lasts: name the camera's file of this "
        "drive, and put its times on the log's clock",
        camera_poses));
  for (std::string& warning : source_warnings(decoder, summary))
    warnings.push_back(std::move(warning));
  if (summary.fault_ns) warnings.push_back(fault(summary));
  if (summary.poses == 0)
    warnings.emplace_back(
        "no pose: the first wheel speed or an initial pose (--initial, [initial] pose, or a camera "
        "pose on the log's clock) is missing");
  return warnings;
}

}  // namespace odomd::tools
