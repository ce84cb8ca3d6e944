// A pose for people and for programs.
#pragma once

#include <odom/types.h>

#include <cstdint>
#include <string>

namespace odomd::tools {

/// Some lines: pose with sigmas, motion, mode and conditions, age.
[[nodiscard]] std::string pose_as_text(const odom_pose& pose, std::int64_t age_ns);

/// One JSON object with its newline. `t_ns` is its time on the clock called `clock`.
[[nodiscard]] std::string pose_as_json(const odom_pose& pose, std::int64_t age_ns,
                                       const std::string& clock, std::int64_t t_ns, bool fresh);

/// One line, for those who watch.
[[nodiscard]] std::string pose_as_line(const odom_pose& pose, std::int64_t t_ns);

}  // namespace odomd::tools
