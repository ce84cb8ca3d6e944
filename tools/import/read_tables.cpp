
#include <algorithm>
#include <cmath>
#include <iterator>
#include <limits>
#include <optional>
#include <sstream>
#include <stdexcept>
#include <utility>

#include <fmt/format.h>
#include <fmt/ranges.h>

#include "base/nearest_name.hpp"
#include "base/printable.hpp"
#include "tools/cli/csv.hpp"
#include "tools/cli/files.hpp"
#include "tools/cli/text.hpp"
#include "tools/import/column_map.hpp"

namespace odomd::tools {
namespace {

using Cells = std::vector<std::string>;

struct OpenTable {
  std::string path, text;
  CsvLayout layout;
  Cells columns, units;               ///< the header, and the row of units below it
  std::vector<MappedColumn*> mapped;  ///< with their names as in the header
};

/// Accepts a decimal comma unless commas separate cells.
std::optional<double> number_in(std::string_view cell, char delimiter) {
  std::string text(cell.substr(cell.starts_with('+') ? 1 : 0));
  if (delimiter != ',') std::ranges::replace(text, ',', '.');
  const auto value = parse_number(text);
  return value && !std::isfinite(*value) ? std::numeric_limits<double>::quiet_NaN() : value;
}

Cells cells_of(std::string line, const CsvLayout& layout) {
  std::vector<std::string_view> cells;
  split_cells(line, layout, cells);
  return {cells.begin(), cells.end()};
}

bool has_number(const Cells& cells, char delimiter) {
  return std::ranges::any_of(cells, [delimiter](const std::string& cell) {
    return number_in(cell, delimiter) || cell.find(':') != std::string::npos;
  });
}

/// The columns that a name means: "speed (km/h)" in imu.csv has this name, "speed", "imu:speed" and
/// "imu.csv:speed". Returns several columns only if they differ in their units alone.
Cells matches(const std::string& table, const Cells& columns, std::string_view name) {
  const std::filesystem::path path(table);
  for (const std::string& before : {path.filename().string() + ':', path.stem().string() + ':'})
    if (name.starts_with(before)) name.remove_prefix(before.size());
  if (std::ranges::find(columns, name) != columns.end()) return {std::string(name)};
  Cells found;
  std::ranges::copy_if(columns, std::back_inserter(found), [name](const std::string& column) {
    return split_unit(column).name == name;
  });
  return found;
}

Cells matches(const OpenTable& table, std::string_view name) {
  return matches(table.path, table.columns, name);
}

/// Finds the header: the line with the most names of `wanted`; if tied, the first with the most
/// cells. Its cells are the names to suggest.
void find_header(OpenTable& table, const std::vector<std::string>& wanted) {
  constexpr std::size_t max_header_line = 200;
  constexpr std::string_view delimiters = "\t;,";  // commas may be decimal ones
  std::istringstream lines(table.text);
  std::pair<std::size_t, std::size_t> most;
  std::string line, below;
  for (std::size_t number = 1; number <= max_header_line && std::getline(lines, line); ++number) {
    if (below.find_first_not_of(" \r") == std::string::npos) below = line;
    for (const char delimiter : delimiters) {
      const CsvLayout layout{
          .delimiter = delimiter, .quote = '"', .comment = '#', .header_line = number};
      Cells columns = cells_of(line, layout);
      const auto names = std::ranges::count_if(wanted, [&](const std::string& name) {
        return !matches(table.path, columns, name).empty();
      });
      const std::pair found(static_cast<std::size_t>(names), columns.size());
      if (found <= most) continue;
      most = found;
      below.clear();
      table.layout = layout;
      table.columns = std::move(columns);
    }
  }
  Cells units = cells_of(below, table.layout);
  if (units.size() == table.columns.size() && !has_number(units, table.layout.delimiter) &&
      !std::ranges::all_of(units, is_missing))
    table.units = std::move(units);
}

OpenTable open_table(const std::string& path, const std::vector<std::string>& wanted) {
  const auto refuse = [&path](std::string_view why) {
    throw std::invalid_argument(fmt::format("{}: {}", path, why));
  };
  const std::string text = read_whole(path);
  if (text.find('\0') != std::string::npos)
    refuse(
        "is not a text in UTF-8; if it is a table in UTF-16, convert it: iconv -f UTF-16 -t "
        "UTF-8");
  if (text.starts_with('('))
    refuse("is a candump log, which needs no import: odom init --can FILE");
  if (text.find("[column names]") != std::string::npos)
    refuse("is a VBOX file (.vbo); save its data as CSV in the VBOX tools");
  OpenTable table{.path = path, .text = to_utf8(text)};
  if (table.text.empty()) refuse("is empty; a table is expected");
  find_header(table, wanted);
  if (has_number(table.columns, table.layout.delimiter))
    throw std::invalid_argument(
        fmt::format("{}:{}: holds numbers where the names of the columns should be; write them as "
                    "the first line",
                    path, table.layout.header_line));
  return table;
}

/// The table that has the column, and the column's name in the header.
std::pair<OpenTable*, std::string> locate(std::vector<OpenTable>& tables, const std::string& column,
                                          std::string_view what = {}) {
  std::pair<OpenTable*, std::string> found;
  Cells all;
  for (OpenTable& table : tables) {
    std::ranges::copy(table.columns, std::back_inserter(all));
    const Cells names = matches(table, column);
    if (names.size() > 1)
      throw std::invalid_argument(fmt::format("{}: column {} may be {}; write the unit, too",
                                              table.path, tools::quoted(column),
                                              fmt::join(names, ", ")));
    if (names.empty()) continue;
    if (found.first != nullptr)
      throw std::invalid_argument(
          fmt::format("column {} is in {} and in {}; name its table too: {}:{}",
                      tools::quoted(column), found.first->path, table.path,
                      std::filesystem::path(table.path).filename().string(), names.front()));
    found = {&table, names.front()};
  }
  if (found.first != nullptr) return found;
  throw std::invalid_argument(fmt::format(
      "{}: no column {}{}{}", tables.size() == 1 ? tables[0].path : counted(tables.size(), "table"),
      tools::quoted(column), what, nearest_hint(column.substr(column.find(':') + 1), all)));
}

std::string_view unit_of(const OpenTable& table, const std::string& column) {
  const auto index =
      static_cast<std::size_t>(std::ranges::find(table.columns, column) - table.columns.begin());
  const std::string_view unit = split_unit(column).unit;
  return unit.empty() && index < table.units.size() ? table.units[index] : unit;
}

/// The time column that is named for this table, otherwise the usual one.
TimeColumn time_of(const OpenTable& table, const ColumnMap& map) {
  for (TimeColumn time : map.times) {
    const bool is_here = std::ranges::all_of(time.columns, [&](std::string& column) {
      const Cells names = matches(table, column);
      if (!names.empty()) column = names.front();
      return !names.empty();
    });
    if (is_here) return time;
  }
  if (auto time = usual_time(table.columns)) return *time;
  throw std::invalid_argument(
      fmt::format("{}: no column is recognised as the time; name it with --time COLUMN: {}",
                  table.path, fmt::join(table.columns, ", ")));
}

double value_in(const CsvReader& reader, std::size_t cell, MappedColumn& column, char delimiter,
                std::int64_t row_ns) {
  const std::string_view text = reader.text(cell);
  if (is_missing(text)) return std::numeric_limits<double>::quiet_NaN();
  if (column.role == "camera.arrival")
    return static_cast<double>(*time_in(reader, cell, column.time_unit) - row_ns) * 1e-9;
  const auto value = number_in(text, delimiter);
  if (!value)
    reader.fail(cell,
                tools::quoted(text) + " is not a number; correct the cell, or leave it empty");
  return column.factor * *value + column.offset;
}

void read_rows(const OpenTable& table, const ColumnMap& map, TimedTable& rows,
               std::vector<std::string>& warnings) {
  TimeColumn time = time_of(table, map);
  rows.time_column = time.columns.front();
  if (time.columns.size() > 1) time.unit = TimeUnit::s;
  take_unit(time, unit_of(table, rows.time_column));
  const bool is_guess = time.unit == TimeUnit::unstated;
  Cells needed = time.columns;
  for (const MappedColumn* column : table.mapped) needed.push_back(column->name);
  std::istringstream text(table.text);
  CsvReader reader(text, table.path, needed, LastLine::keep_whole, table.layout);
  if (!table.units.empty()) static_cast<void>(reader.next());
  std::size_t without_time = 0;
  while (reader.next()) {
    const auto time_ns = time_in(reader, time);
    if (!time_ns) {
      ++without_time;
      continue;
    }
    if (!rows.times_ns.empty() && *time_ns < rows.times_ns.back())
      throw std::invalid_argument(fmt::format(
          "{}: the time runs back by {:.6f} s; sort the rows by {}, or cut the table there",
          reader.place(), static_cast<double>(rows.times_ns.back() - *time_ns) * 1e-9,
          tools::quoted(rows.time_column)));
    rows.times_ns.push_back(*time_ns);
    std::size_t cell = time.columns.size();
    for (MappedColumn* column : table.mapped)
      column->values.push_back(value_in(reader, cell++, *column, table.layout.delimiter, *time_ns));
  }
  if (rows.times_ns.empty()) throw std::invalid_argument(table.path + ": has no rows");
  if (is_guess && time.unit == TimeUnit::s)
    require_seconds(rows.times_ns, table.path, rows.time_column);
  warnings.insert(warnings.end(), reader.warnings().begin(), reader.warnings().end());
  if (without_time > 0)
    warnings.push_back(
        fmt::format("{}: {} without a time left out", table.path, counted(without_time, "row")));
}

}  // namespace

void read_tables(ColumnMap& map, const ReportProgress& report, std::vector<std::string>& warnings) {
  if (map.tables.empty()) throw std::invalid_argument("no table: name its file");
  std::vector<std::string> wanted;
  for (const MappedColumn& column : map.columns)
    if (!column.name.empty()) wanted.push_back(column.name);
  for (const TimeColumn& time : map.times) std::ranges::copy(time.columns, back_inserter(wanted));

  std::vector<OpenTable> tables;
  for (const TimedTable& table : map.tables) tables.push_back(open_table(table.name, wanted));
  for (const TimeColumn& time : map.times)
    if (std::ranges::all_of(tables, [&](const OpenTable& table) {
          return matches(table, time.columns.front()).empty();
        }))
      static_cast<void>(locate(tables, time.columns.front(), " for the time"));
  for (MappedColumn& column : map.columns) {
    if (column.name.empty()) continue;
    const auto [table, name] = locate(tables, column.name);
    read_keys(column, unit_of(*table, name));
    column.table = static_cast<std::size_t>(table - tables.data());
    column.name = name;
    column.place = fmt::format("{}: {}", table->path, name);
    table->mapped.push_back(&column);
  }
  for (std::size_t i = 0; i < tables.size(); ++i) {
    if (report) report(tables[i].path);
    if (!tables[i].mapped.empty()) read_rows(tables[i], map, map.tables[i], warnings);
  }
}

}  // namespace odomd::tools
