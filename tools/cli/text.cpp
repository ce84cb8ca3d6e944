#include "tools/cli/text.hpp"

#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>

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

std::string Table::text() const {
  std::vector<std::vector<std::string>> all{header};
  all.insert(all.end(), rows.begin(), rows.end());
  align_columns(all, flush_left, [](std::string& cell) -> std::string& { return cell; });
  std::string out;
  for (const auto& cells : all) {
    std::string line;
    for (std::size_t i = 0; i < cells.size(); ++i) line += (i == 0 ? "" : "  ") + cells[i];
    line.erase(line.find_last_not_of(' ') + 1);
    out += line + '\n';
  }
  return out;
}

}  // namespace odomd::tools
