#include "tools/json_text.hpp"

#include <fmt/format.h>

namespace odomd::tools {

std::string json_text(const nlohmann::ordered_json& value, int indent) {
  return value.dump(indent, ' ', false, nlohmann::ordered_json::error_handler_t::replace);
}

std::string shortest(double value) {
  std::string text = json_text(value);
  if (text.ends_with(".0")) text.resize(text.size() - 2);
  if (text == "null") return fmt::format("{}", value);  // JSON has no word for inf and nan
  return text;
}

}  // namespace odomd::tools
