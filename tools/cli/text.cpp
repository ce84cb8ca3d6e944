#include "tools/cli/text.hpp"

#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

namespace odomd::tools {

std::string fixed(double value, int decimals) {
  constexpr double largest = 1e15;
  std::array<char, 64> buffer{};
  const auto format =
      std::abs(value) < largest ? std::chars_format::fixed : std::chars_format::scientific;
  const auto result =
      std::to_chars(buffer.data(), buffer.data() + buffer.size(), value, format, decimals);
  std::string text{buffer.data(), result.ptr};
  if (text.starts_with('-') && text.find_first_not_of("-0.") == std::string::npos) text.erase(0, 1);
  return text;
}

std::string counted(std::uint64_t number, std::string_view noun) {
  return std::to_string(number) + ' ' + std::string{noun} + (number == 1 ? "" : "s");
}

std::size_t width(std::string_view text) {
  return static_cast<std::size_t>(std::count_if(text.begin(), text.end(), [](char c) {
    return (static_cast<unsigned char>(c) & 0xC0U) != 0x80U;  // not a continuation byte
  }));
}

std::vector<std::vector<std::string>> Table::aligned() const {
  std::vector<std::vector<std::string>> all{header};
  all.insert(all.end(), rows.begin(), rows.end());
  std::vector<std::size_t> widths;
  for (const auto& cells : all) {
    widths.resize(std::max(widths.size(), cells.size()));
    for (std::size_t i = 0; i < cells.size(); ++i) widths[i] = std::max(widths[i], width(cells[i]));
  }
  for (auto& cells : all)
    for (std::size_t i = 0; i < cells.size(); ++i) {
      const bool left = std::ranges::find(flush_left, i) != flush_left.end();
      cells[i].insert(left ? cells[i].size() : 0, widths[i] - width(cells[i]), ' ');
    }
  return all;
}

std::string Table::text() const {
  std::string out;
  for (const auto& cells : aligned()) {
    std::string line;
    for (std::size_t i = 0; i < cells.size(); ++i) line += (i == 0 ? "" : "  ") + cells[i];
    line.erase(line.find_last_not_of(' ') + 1);
    out += line + '\n';
  }
  return out;
}

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
