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

/// One JSON object with its newline. `t_ns` is its time on the clock called `clock`.
[[nodiscard]] std::string pose_as_json(const odom_pose& pose, std::int64_t age_ns,
                                       const std::string& clock, std::int64_t t_ns, bool fresh);

/// One line, for those who watch.
[[nodiscard]] std::string pose_as_line(const odom_pose& pose, std::int64_t t_ns);

/// `before`, where it is given, is an earlier document of the same daemon: rates are those in
/// between, else those since start. Members that are missing are shown as "-". Throws a
/// nlohmann::json::exception where a member is of another type than it must be.
[[nodiscard]] std::string status_as_text(const nlohmann::json& document,
                                         const std::optional<nlohmann::json>& before);

/// OpenMetrics, with such types only that Prometheus' older text format has, too: node_exporter can
/// collect the text from a file. None: nobody answers. Throws as status_as_text().
[[nodiscard]] std::string open_metrics(const std::optional<nlohmann::json>& status);

}  // namespace odomd::tools
