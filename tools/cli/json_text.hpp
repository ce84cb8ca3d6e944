// JSON as text, and numbers for people as short as JSON has them.
#pragma once

#include <nlohmann/json.hpp>
#include <string>
#include <string_view>

namespace odomd::tools {

/// JSON text; bytes that are no UTF-8 are replaced. `indent` -1: on one line.
[[nodiscard]] std::string json_text(const nlohmann::ordered_json& value, int indent = -1);

/// Whether JSON text is nested deeper than any of ours: the library reads it, but copies and writes
/// values by recursion. One pass; what is no JSON may be either.
[[nodiscard]] bool is_nested_too_deep(std::string_view text);

/// Shortest decimal form that reads back the same, for people: 5, not 5.0.
[[nodiscard]] std::string shortest(double value);

}  // namespace odomd::tools
