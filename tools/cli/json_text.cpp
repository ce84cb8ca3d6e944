#include "tools/cli/json_text.hpp"

#include <fmt/format.h>
#include <nlohmann/json.hpp>

namespace odomd::tools {

std::string json_text(const nlohmann::ordered_json& value, int indent) {
  return value.dump(indent, ' ', false, nlohmann::ordered_json::error_handler_t::replace);
}

bool is_nested_too_deep(std::string_view text) {
  constexpr int deepest = 32;
  int open = 0;
  bool quoted = false;
  for (std::size_t at = 0; at < text.size(); ++at) {
    const char c = text[at];
    if (quoted && c == '\\') {
      ++at;
    } else if (c == '"') {
      quoted = !quoted;
    } else if (!quoted && (c == '[' || c == '{')) {
      if (++open > deepest) return true;
    } else if (!quoted && (c == ']' || c == '}')) {
      --open;
    }
  }
  return false;
}

std::string shortest(double value) {
  std::string text = json_text(value);
  if (text.ends_with(".0")) text.resize(text.size() - 2);
  if (text == "null") return fmt::format("{}", value);  // JSON has no word for inf and nan
  return text;
}

}  // namespace odomd::tools
