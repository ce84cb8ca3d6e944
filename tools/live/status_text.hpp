// The daemon's status document as text.
#pragma once

#include <nlohmann/json_fwd.hpp>
#include <optional>
#include <string>

namespace odomd::tools {

/// `now` is the document; `before`, where it is given, an earlier one of the same daemon: rates are
/// those in between, else those since start. Members that are missing are shown as "-". Throws a
/// nlohmann::json::exception where a member is of another type than it must be.
[[nodiscard]] std::string status_as_text(const nlohmann::json& now,
                                         const std::optional<nlohmann::json>& before);

}  // namespace odomd::tools
