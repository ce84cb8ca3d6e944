// Text for people: numbers with fixed decimals and tables that line up.
#pragma once

#include <cstddef>
#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

namespace odomd::tools {

/// Fixed decimals, "." whatever the locale, never "-0.00"; beyond 10¹⁵ in exponent form.
[[nodiscard]] std::string fixed(double value, int decimals);

/// "1 reset", "2 resets".
[[nodiscard]] std::string counted(std::uint64_t number, std::string_view noun);

/// Width on the terminal: characters, not bytes, of UTF-8.
[[nodiscard]] std::size_t width(std::string_view text);

/// Columns are flush right but for those in `flush_left`; two spaces in between.
struct Table {
  std::vector<std::string> header;
  std::vector<std::vector<std::string>> rows;
  std::vector<std::size_t> flush_left{0};

  [[nodiscard]] std::string text() const;
};

}  // namespace odomd::tools
