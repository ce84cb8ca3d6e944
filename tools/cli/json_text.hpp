// JSON as text, and numbers as short as in JSON.
#pragma once

#include <nlohmann/json_fwd.hpp>
#include <string>
#include <string_view>

namespace odomd::tools {

/// JSON text; bytes that are not UTF-8 are replaced. `indent` -1: on one line.
[[nodiscard]] std::string json_text(const nlohmann::ordered_json& value, int indent = -1);

/// Whether JSON text is nested deeper than any of ours. The library would read it, but copies and
/// writes values recursively. One pass; for invalid JSON the result is arbitrary.
[[nodiscard]] bool is_nested_too_deep(std::string_view text);

/// Shortest decimal form that reads back the same, for people: 5, not 5.0.
[[nodiscard]] std::string shortest(double value);

}  // namespace odomd::tools
