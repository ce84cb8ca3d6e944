// The daemon's status in OpenMetrics, with such types only that Prometheus' older text format has,
// too: node_exporter can collect the text from a file.
#pragma once

#include <nlohmann/json_fwd.hpp>
#include <optional>
#include <string>

namespace odomd::tools {

/// `status`: the document of the status socket; none: nobody answers. Throws a
/// nlohmann::json::exception where it is another version's.
[[nodiscard]] std::string open_metrics(const std::optional<nlohmann::json>& status);

}  // namespace odomd::tools
