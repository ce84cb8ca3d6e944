// The daemon's pose and status for people and for programs.
#pragma once

#include <odom/types.h>

#include <cstdint>
#include <nlohmann/json_fwd.hpp>
#include <optional>
#include <string>

namespace odomd::tools {

/// Some lines: pose with sigmas, motion, mode and conditions, age.
[[nodiscard]] std::string pose_as_text(const odom_pose& pose, std::int64_t age_ns);

/// One JSON object and a newline. `t_ns` is the pose's time on the clock named `clock`.
[[nodiscard]] std::string pose_as_json(const odom_pose& pose, std::int64_t age_ns,
                                       const std::string& clock, std::int64_t t_ns, bool fresh);

/// The pose in one line, to be watched.
[[nodiscard]] std::string pose_as_line(const odom_pose& pose, std::int64_t t_ns);

/// `before`, if given, is an earlier document of the same daemon: rates are those since then,
/// otherwise since the daemon's start. Missing members are shown as "-". Throws a
/// nlohmann::json::exception if a member has the wrong type.
[[nodiscard]] std::string status_as_text(const nlohmann::json& document,
                                         const std::optional<nlohmann::json>& before);

/// OpenMetrics, restricted to the types of Prometheus' older text format, so that node_exporter can
/// collect the text from a file. No status: nobody answers. Throws as status_as_text().
[[nodiscard]] std::string open_metrics(const std::optional<nlohmann::json>& status);

}  // namespace odomd::tools
