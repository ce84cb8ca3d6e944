// Text for people: numbers with fixed decimals, tables that line up, JSON, errors.
#pragma once

#include <cstddef>
#include <cstdint>
#include <stdexcept>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include <fmt/format.h>
#include <nlohmann/json_fwd.hpp>

namespace odomd::tools {

/// Fixed decimals, "." whatever the locale, never "-0.00"; beyond 10¹⁵ in exponent form.
[[nodiscard]] std::string fixed(double value, int decimals);

/// "1 reset", "2 resets".
[[nodiscard]] std::string counted(std::uint64_t number, std::string_view noun);

/// Width on the terminal: characters, not bytes, of UTF-8.
[[nodiscard]] std::size_t width(std::string_view text);

/// Columns are right-aligned except those in `flush_left`; two spaces in between.
struct Table {
  std::vector<std::string> header;
  std::vector<std::vector<std::string>> rows;
  std::vector<std::size_t> flush_left{0};

  /// Header and rows, with the cells of each column padded to one width.
  [[nodiscard]] std::vector<std::vector<std::string>> aligned() const;
  [[nodiscard]] std::string text() const;
};

/// JSON text; bytes that are not UTF-8 are replaced. `indent` -1: on one line.
[[nodiscard]] std::string json_text(const nlohmann::ordered_json& value, int indent = -1);

/// Whether JSON text is nested deeper than any of ours. The library would read it, but copies and
/// writes values recursively. One pass; for invalid JSON the result is arbitrary.
[[nodiscard]] bool is_nested_too_deep(std::string_view text);

/// Shortest decimal form that reads back the same, for people: 5, not 5.0.
[[nodiscard]] std::string shortest(double value);

/// Throws std::invalid_argument: what is wrong with an input, and how to fix it.
template <typename... Values>
[[noreturn]] void refuse(fmt::format_string<Values...> text, Values&&... values) {
  throw std::invalid_argument(fmt::format(text, std::forward<Values>(values)...));
}

}  // namespace odomd::tools
