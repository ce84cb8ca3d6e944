// Strict CSV: columns by the names in the header, numbers exact to the last bit, times as integers,
// and errors that name the file, the line and the column.
#pragma once

#include <charconv>
#include <concepts>
#include <cstddef>
#include <cstdint>
#include <iosfwd>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "base/printable.hpp"

namespace odomd::tools {

/// The number that the whole text represents, also an infinite one or NaN; nothing if it does not
/// fit into the type.
template <typename T = double>
[[nodiscard]] std::optional<T> parse_number(std::string_view text) {
  T value{};
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
  return error == std::errc{} && end == text.data() + text.size() ? std::optional(value)
                                                                  : std::nullopt;
}

/// How to treat a last line without a newline, as left by a recorder that lost power.
enum class LastLine : std::uint8_t {
  drop_unended,  ///< it may have lost digits: leave it out, with a warning
  keep_whole,    ///< use it if all its fields are there, with a warning; otherwise leave it out
};

/// Layout of a table; the defaults are those of a recording.
struct CsvLayout {
  std::size_t required = SIZE_MAX;  ///< this many first columns must exist
  char delimiter = ',';
  std::optional<char> quote;    ///< around cells; surplus empty cells may then end a row
  std::optional<char> comment;  ///< starts lines that are skipped
  std::size_t header_line = 1;  ///< 0: no header, the columns come in the expected order
};

/// Reads row by row, so that a pipe can be followed. Throws std::invalid_argument for unusable
/// input, std::runtime_error when reading fails. Blank lines are skipped; CRLF and spaces around a
/// field are accepted.
class CsvReader {
 public:
  /// Reads the header. `name` is the name of the input in messages. Other columns are ignored.
  CsvReader(std::istream& input, std::string name, std::vector<std::string> columns,
            LastLine last_line = LastLine::keep_whole, CsvLayout layout = {});

  /// Moves to the next row; false at the end.
  [[nodiscard]] bool next();

  /// Whether the header has the column with this index.
  [[nodiscard]] bool has(std::size_t column) const { return positions_[column].has_value(); }

  // Fields of the current row: a finite number; a time in nanoseconds, rounded to the nearest; an
  // integer; the index of a word in a list, where `otherwise` ends the error about a word that is
  // not in it.
  [[nodiscard]] double number(std::size_t column) const;
  [[nodiscard]] std::int64_t time_ns(std::size_t column) const;
  template <std::integral T>
  [[nodiscard]] T count(std::size_t column) const {
    const auto value = parse_number<T>(text(column));
    if (!value) fail(column, quoted(text(column)) + " is not a count; correct or remove the line");
    return *value;
  }
  [[nodiscard]] std::size_t word(std::size_t column, std::span<const std::string_view> words,
                                 std::string_view otherwise) const;
  [[nodiscard]] std::string_view text(std::size_t column) const;

  /// Throws the error "file:line: column "x": what".
  [[noreturn]] void fail(std::size_t column, const std::string& what) const;

  /// "file:line" of the current row.
  [[nodiscard]] std::string place() const;

  [[nodiscard]] const std::vector<std::string>& warnings() const { return warnings_; }

 private:
  enum class LineEnd : std::uint8_t { newline, end_of_input };
  [[nodiscard]] bool read_line();

  std::istream& input_;
  std::string name_;
  std::vector<std::string> columns_;
  std::vector<std::optional<std::size_t>> positions_;  ///< of columns_ in a row
  LastLine last_line_;
  CsvLayout layout_;
  std::size_t header_fields_ = 0;
  std::size_t line_number_ = 0;
  std::string line_;
  LineEnd line_end_ = LineEnd::newline;
  std::vector<std::string_view> fields_;
  std::vector<std::string> warnings_;
};

/// Splits the line into `cells`, without the blanks around them and without their quotes; the
/// quotes are also removed from `line`.
void split_cells(std::string& line, const CsvLayout& layout, std::vector<std::string_view>& cells);

/// Converts decimal seconds to nanoseconds in integer arithmetic, never through a double; digits
/// beyond the ninth decimal are rounded. Nothing if the text is not a number or does not fit.
[[nodiscard]] std::optional<std::int64_t> parse_seconds(std::string_view text);

inline constexpr int all_digits = -1;
/// Appends `value` with this number of decimals, or in the shortest form that reads back to the
/// same bits. Throws std::runtime_error for a number that is too long.
void append_number(std::string& out, double value, int decimals = all_digits);

/// The shortest form as a float of TOML: always with a decimal point or an exponent.
[[nodiscard]] std::string toml_number(double value);

/// Seconds with nine decimals.
void append_seconds(std::string& out, std::int64_t time_ns);

/// "a,b".
[[nodiscard]] std::string joined(std::span<const std::string> names);

using odomd::quoted;

}  // namespace odomd::tools
