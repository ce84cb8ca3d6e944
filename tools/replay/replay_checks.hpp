// Reports of a successful replay: what may be wrong with its poses, and the result as JSON. And
// poses that cannot be compared: from another drive, for only a part of the drive, in other axes,
// or in units other than metres and radians (wheels or gyro would then look wrong).
#pragma once

#include <cstdint>
#include <nlohmann/json_fwd.hpp>
#include <optional>
#include <span>
#include <string>

#include "can_protocol/decode/decoder.hpp"
#include "daemon/core/config.hpp"
#include "daemon/diagnostics/diagnostic.hpp"
#include "estimator/common/measurement.hpp"
#include "tools/drive_files/trajectory.hpp"
#include "tools/replay/virtual_drive.hpp"

namespace odomd::tools {

/// Why a mapped message gave no value; empty if it gave one.
[[nodiscard]] std::optional<diagnostics::Diagnostic> check_message(
    const can::BoundMessage& message, const can::MessageCounters& counters);

/// Reports a source if too many of its `judged` samples (gated or fused) were gated; `label` names
/// it. Nothing if fewer than ten were judged.
[[nodiscard]] std::optional<diagnostics::Diagnostic> check_gating(estimator::Source source,
                                                                  const std::string& label,
                                                                  std::uint64_t gated,
                                                                  std::uint64_t judged);

/// First reports each wiring fault that was found at any time (daemon/core/wiring.hpp), with its
/// sources but without its consequences, and a bias or scale that the filter did not learn or
/// learnt implausibly. Then reports, for each source: that it was inconsistent with the filter;
/// each flag that lasted a second or more (or a tenth of a shorter drive), except slips and
/// time-outs; that over a tenth of its samples was not used, or that it was silent for over a tenth
/// of the time; that over a tenth of its samples was gated.
[[nodiscard]] diagnostics::Diagnostics check_sources(const can::Decoder& decoder,
                                                     const ReplaySummary& summary);

/// Reports a mode that became fault: when, for how long, and the conditions that say why.
[[nodiscard]] std::optional<diagnostics::Diagnostic> check_mode(const ReplaySummary& summary);

/// Reports mapped messages without frames, without decoded frames or with frames cut off; frames
/// out of order; a camera outside the log; what check_sources() finds; a model that stopped; and,
/// last, a drive without a pose.
[[nodiscard]] diagnostics::Diagnostics check_replay(const can::Decoder& decoder,
                                                    const ReplaySummary& summary);

/// Counts, times, how the samples of each source were judged, and warnings. `seconds`: how long the
/// replay took.
[[nodiscard]] nlohmann::ordered_json replay_json(const ReplaySummary& summary, double seconds,
                                                 const diagnostics::Diagnostics& warnings);

/// The innovations per source, for sources with tested samples.
[[nodiscard]] nlohmann::ordered_json innovations_json(const ReplaySummary& summary);

/// The number of samples per source and verdict; zeros are left out.
[[nodiscard]] nlohmann::ordered_json verdicts_json(const ReplaySummary& summary);

/// Warns of an estimate that covers only a part of the drive: a file that was cut off or has a gap.
/// Nothing if it covers enough of the reference's path. Time at standstill does not count.
[[nodiscard]] std::optional<diagnostics::Diagnostic> check_coverage(const Trajectory& reference,
                                                                    const Trajectory& estimate);

/// Warns if reference and estimate belong to different drives, or look exchanged (only the
/// reference has sigmas). Their clocks start alike, so all figures would look like those of a bad
/// filter; but their turns differ from second to second. Nothing if the reference hardly turns.
[[nodiscard]] std::optional<diagnostics::Diagnostic> drive_mismatch(const Trajectory& reference,
                                                                    const Trajectory& estimate);

/// Warns of a file in degrees, or with a clockwise yaw. Nothing if the headings follow the path, or
/// if the car hardly moves or turns. A car that reverses or drifts gives no warning.
[[nodiscard]] std::optional<diagnostics::Diagnostic> check_headings(const Trajectory& trajectory);

/// Warns of an [initial] pose from the configuration of another drive: one far from the camera's
/// poses in the first fifth of a second; nothing if there are no such poses.
[[nodiscard]] std::optional<diagnostics::Diagnostic> check_initial_pose(
    const daemon::Config& config, std::span<const estimator::CameraPose> cameras,
    std::int64_t first_tick_ns);

/// The motion that poses are compared with. Only its distances and turns matter, not its start.
struct Driven {
  const Trajectory& trajectory;
  std::string way_of = "the wheels";  ///< source of the distances, in messages
  std::string turn_of = "the gyro";
};

/// Reports poses of `subject` that go a hundred or a thousand times as far as driven, or turn 57
/// times as far. Empty if they do not, or if the drive is too short to decide.
[[nodiscard]] diagnostics::Diagnostics check_units(const std::string& subject,
                                                   std::span<const TrajectoryPoint> poses,
                                                   const Driven& driven);

/// The same for poses of a camera, in any order.
[[nodiscard]] diagnostics::Diagnostics check_units(const std::string& subject,
                                                   std::span<const estimator::CameraPose> poses,
                                                   const Driven& driven);

}  // namespace odomd::tools
