// Diagnostics of the poses in files.
#pragma once

#include <array>

#include "daemon/diagnostics/diagnostic.hpp"

namespace odomd::diagnostics {

/// Poses of the camera, of the reference and of an estimate.
inline constexpr auto poses = std::to_array<Kind>({
    {"W401", "positions_in_millimetres", "Positions are 1000 times too large.",
     "positions must be in metres"},
    {"W402", "positions_in_centimetres", "Positions are 100 times too large.",
     "positions must be in metres"},
    {"W403", "yaw_in_degrees", "Headings are 57 times too large.", "yaw must be in radians"},
    {"W404", "headings_off_path", "The headings do not follow the path.",
     "yaw must be in radians, counter-clockwise from the x axis", at_least(0.65), "",
     "agreement of course and heading; a long drift has 0.77"},
    {"W405", "no_camera_pose", "The camera's file has no pose.",
     "check whether the tracker saw the car"},
    {"W406", "camera_columns_exchanged", "Camera poses arrive before their capture.",
     "check whether the columns t_arrival and t_capture are exchanged"},
    {"W407", "camera_outside_log", "No camera pose falls into the log.",
     "name the camera's file of this drive, and put its times on the log's clock"},
    {"W408", "initial_pose_elsewhere", "The initial pose is far from the camera's first.",
     "remove [initial] pose to start from the first camera pose, or set this drive's", at_most(0.5),
     "m or rad", "excess over 5 sigmas + possible motion"},
    {"W409", "clocks_differ", "Poses are not on the log's clock.",
     "put them on the log's clock, t_capture at the time of the picture, or state the "
     "signals' latencies (odom identify latency)"},
    {"W410", "other_drive", "Reference and estimate turn differently.",
     "check that both are of one drive and clock, and the yaw's sign", at_most(0.7), "",
     "rms of the difference over rms of the turn"},
    {"W411", "exchanged", "The reference has sigmas, the estimate none.",
     "check whether --reference and --pose are exchanged"},
    {"W412", "reference_covers_part", "The reference covers part of the estimate.",
     "the rest is not evaluated", at_least(0.9), "", "share of the time"},
    {"W413", "estimate_covers_part", "The estimate covers part of the reference.",
     "all figures are for that part only", at_least(0.9), "", "share of the path"},
    {"W414", "reference_gap", "The reference has a gap.",
     "it is bridged by a straight line; --from and --to leave a part out", at_most(0.2), "s",
     "no path is straight for longer"},
    {"W415", "reference_jumps", "The reference jumps.",
     "path length, maxima and 35 ms errors include these jumps", at_most(100.0), "m/s",
     "faster than any car"},
    {"W416", "reference_stuck", "The reference stops while the estimate moves.",
     "check whether its tracker lost the car or the wheels spin; --from and --to leave a "
     "part out"},
    {"W417", "other_time", "The estimates cover different times.",
     "compare their figures with care", at_most(0.01), "", "share of the time"},
    {"W418", "loop_closes_badly", "The drive does not end where it began.",
     "the figures include the car's distance from its start"},
    {"W419", "camera_turns_unrelated", "The poses' turns and the gyro's are unrelated.",
     "check the file's drive and clock, and that yaw_rate is the right signal"},
});
inline constexpr Chapter pose_chapter{"Poses: camera, reference and estimate", poses};

[[nodiscard]] consteval const Kind& pose_kind(std::string_view name) {
  return kind(name, {&pose_chapter, 1});
}

}  // namespace odomd::diagnostics
