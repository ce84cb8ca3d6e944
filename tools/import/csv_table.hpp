// Tables as loggers write them: any delimiter, quoted cells, decimal commas, lines before the
// header and a row of units below it. Compare tools/cli/csv.hpp, which reads odom's own files.
#pragma once

#include <cstddef>
#include <filesystem>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

namespace odomd::tools {

/// A name without the unit in brackets at its end: "speed" and "km/h" of "speed (km/h)".
struct NameAndUnit {
  std::string_view name;
  std::string_view unit;
};
[[nodiscard]] NameAndUnit split_unit(std::string_view column);

class CsvTable {
 public:
  /// Finds the delimiter and the header, the line with most of the `wanted` names. A column may
  /// also be named without its unit, or by its number: "#3". Throws std::invalid_argument for what is no table.
  CsvTable(const std::filesystem::path& file, std::span<const std::string> wanted);

  [[nodiscard]] const std::string& name() const { return name_; }
  [[nodiscard]] const std::vector<std::string>& columns() const { return columns_; }
  /// Throws std::invalid_argument if two columns have this name.
  [[nodiscard]] std::optional<std::size_t> find(std::string_view column) const;
  /// As the header or the row below it states; may be empty.
  [[nodiscard]] std::string_view unit(std::size_t column) const;

  /// Moves to the next row; false at the end. A last line that is cut off is left out.
  [[nodiscard]] bool next();
  /// The share of the file that has been read.
  [[nodiscard]] double progress() const;
  /// Empty where the value is missing: nothing, "nan", "null", "n/a", "-", ...
  [[nodiscard]] std::string_view cell(std::size_t column) const;
  [[nodiscard]] std::optional<double> number(std::size_t column) const;

  /// "imu.csv:12"
  [[nodiscard]] std::string place() const;
  /// Throws "imu.csv:12: column 'x': what".
  [[noreturn]] void fail(std::size_t column, const std::string& what) const;

 private:
  struct Layout;  // a line as a header
  [[nodiscard]] std::optional<std::string_view> read_line();
  [[nodiscard]] std::vector<std::string> split(std::string_view line, char delimiter) const;
  void find_layout(std::span<const std::string> wanted);
  void take_units();

  std::string name_;
  std::string text_;
  std::size_t offset_ = 0;  ///< of the next line
  std::size_t line_ = 0;    ///< number of the current one
  char delimiter_ = ',';
  std::vector<std::string> columns_;  ///< none: the table has no header
  std::vector<std::string> units_;    ///< of the row below the header
  std::vector<std::string> cells_;
};

/// A number with a point, or a comma where no comma separates cells; "true" is 1, "false" 0.
[[nodiscard]] std::optional<double> parse_cell(std::string_view text, char delimiter);

}  // namespace odomd::tools
