// The daemon's status document as text: sections for people, and metrics for programs.
#pragma once

#include <cstddef>
#include <optional>
#include <string>
#include <string_view>

#include "tools/live/line.hpp"
#include "tools/live/status_value.hpp"

namespace odomd::tools {

/// "── pose ── note ──────", as wide as the page.
[[nodiscard]] Line title(std::string_view name, std::string_view note, std::size_t columns);

/// Sources, beat, calibrations, camera, buses, messages and noise, each with its title; those
/// without content are absent. Missing members are shown as "-". Throws a
/// nlohmann::json::exception if a member has the wrong type.
[[nodiscard]] Lines status_sections(const StatusValue& status, std::size_t columns);

/// OpenMetrics, restricted to the types of Prometheus' older text format, so that node_exporter can
/// collect the text from a file. Empty status: nobody answers. Throws like status_sections().
[[nodiscard]] std::string open_metrics(const std::optional<Json>& status);

}  // namespace odomd::tools
