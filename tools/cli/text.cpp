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
  std::vector<std::size_t> widths;
  const auto measure = [&widths](const std::vector<std::string>& cells) {
    widths.resize(std::max(widths.size(), cells.size()));
    for (std::size_t i = 0; i < cells.size(); ++i) {
      widths[i] = std::max(widths[i], width(cells[i]));
    }
  };
  measure(header);
  for (const auto& row : rows) measure(row);

  std::string out;
  const auto write = [&](const std::vector<std::string>& cells) {
    std::string line;
    for (std::size_t i = 0; i < cells.size(); ++i) {
      const std::string padding(widths[i] - width(cells[i]), ' ');
      const bool left = std::find(flush_left.begin(), flush_left.end(), i) != flush_left.end();
      line += i == 0 ? "" : "  ";
      line += left ? cells[i] + padding : padding + cells[i];
    }
    line.erase(line.find_last_not_of(' ') + 1);
    out += line + '\n';
  };
  write(header);
  for (const auto& row : rows) write(row);
  return out;
}

}  // namespace odomd::tools
