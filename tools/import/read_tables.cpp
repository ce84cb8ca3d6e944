#include "tools/import/read_tables.hpp"

#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>
#include <iterator>
#include <limits>
#include <memory>
#include <optional>
#include <sstream>
#include <stdexcept>

#include <fmt/format.h>
#include <fmt/ranges.h>

#include "base/nearest_name.hpp"
#include "can_protocol/dbc/text.hpp"
#include "tools/cli/csv.hpp"
#include "tools/cli/files.hpp"
#include "tools/cli/text.hpp"

namespace odomd::tools {
namespace {

struct OpenTable {
  std::string path;
  std::istringstream text;
  CsvLayout layout{.quote = '"', .comment = '#'};
  std::vector<std::string> columns;
  std::vector<std::string> units;     ///< of the row below the header
  std::vector<std::string> needed;    ///< columns
  std::vector<MappedColumn*> mapped;  ///< with the index of each in needed
  std::vector<std::size_t> indices;
};

/// A decimal comma where no comma separates cells.
std::optional<double> number_in(std::string_view cell, char delimiter) {
  std::string text(cell.substr(cell.starts_with('+') ? 1 : 0));
  if (delimiter != ',') std::ranges::replace(text, ',', '.');
  double value = 0.0;
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
  if (error != std::errc{} || end != text.data() + text.size()) return std::nullopt;
  return std::isfinite(value) ? value : std::numeric_limits<double>::quiet_NaN();
}

bool is_missing(std::string_view cell) {
  constexpr std::array<std::string_view, 14> texts{"",     "nan", "NaN",  "null",     "NULL",
                                                   "None", "n/a", "N/A",  "na",       "NA",
                                                   "-",    "--",  "#N/A", "-nan(ind)"};
  return std::ranges::find(texts, cell) != texts.end();
}

std::vector<std::string> cells_of(std::string line, const CsvLayout& layout) {
  std::vector<std::string_view> cells;
  split_cells(line, layout, cells);
  return {cells.begin(), cells.end()};
}

bool has_number(const std::vector<std::string>& cells, char delimiter) {
  return std::ranges::any_of(cells, [delimiter](const std::string& cell) {
    return (!cell.empty() && number_in(cell, delimiter)) || cell.find(':') != std::string::npos;
  });
}

/// "speed (km/h)" of that, "speed", "imu:speed" and "imu.csv:speed" in imu.csv; several if the unit
/// decides.
std::vector<std::string> matches(const OpenTable& table, std::string_view name) {
  const std::filesystem::path path(table.path);
  for (const std::string& before : {path.filename().string() + ':', path.stem().string() + ':'})
    if (name.starts_with(before)) name.remove_prefix(before.size());
  if (std::ranges::find(table.columns, name) != table.columns.end()) return {std::string(name)};
  std::vector<std::string> found;
  for (const std::string& column : table.columns)
    if (split_unit(column).name == name) found.push_back(column);
  return found;
}

/// The header is the first line with most of the wanted names, and of these with most cells: it has
/// the names to suggest, too.
void find_header(OpenTable& table, const std::vector<std::string>& wanted) {
  constexpr std::size_t max_header_line = 200;
  constexpr std::string_view delimiters = "\t;,";  // commas may be decimal ones
  std::pair<std::size_t, std::size_t> most;
  std::size_t number = 0;
  std::string line;
  while (number < max_header_line && std::getline(table.text, line)) {
    ++number;
    for (const char delimiter : delimiters) {
      OpenTable candidate{.path = table.path, .layout = table.layout};
      candidate.layout.delimiter = delimiter;
      candidate.layout.header_line = number;
      candidate.columns = cells_of(line, candidate.layout);
      const auto names = std::ranges::count_if(
          wanted, [&](const std::string& name) { return !matches(candidate, name).empty(); });
      const std::pair found(static_cast<std::size_t>(names), candidate.columns.size());
      if (found <= most) continue;
      most = found;
      table.layout = candidate.layout;
      table.columns = std::move(candidate.columns);
    }
  }
  if (number == 0) throw std::invalid_argument(table.path + ": is empty; a table is expected");
  table.text.clear();
  table.text.seekg(0);
  for (number = 0; number < table.layout.header_line; ++number) std::getline(table.text, line);
  while (std::getline(table.text, line) && line.find_first_not_of(" \r") == std::string::npos) {
  }
  auto below = cells_of(line, table.layout);
  if (table.text && below.size() == table.columns.size() &&
      !has_number(below, table.layout.delimiter) && !std::ranges::all_of(below, is_missing))
    table.units = std::move(below);
  table.text.clear();
  table.text.seekg(0);
}

std::unique_ptr<OpenTable> open_table(const std::string& path,
                                      const std::vector<std::string>& wanted) {
  auto table = std::make_unique<OpenTable>(OpenTable{.path = path});
  auto input = open_input(path);
  std::string text(std::istreambuf_iterator<char>(input), {});
  if (input.bad()) throw std::runtime_error(path + ": cannot be read");
  if (text.find('\0') != std::string::npos)
    throw std::invalid_argument(path +
                                ": is not a text in UTF-8; if it is a table in UTF-16, convert it: "
                                "iconv -f UTF-16 -t UTF-8");
  table->text = std::istringstream(can::to_utf8(text));
  if (text.starts_with('(') || text.find("[column names]") != std::string::npos)
    throw std::invalid_argument(
        path + (text.starts_with('(')
                    ? ": is a candump log, which needs no import: odom init --can FILE"
                    : ": is a VBOX file (.vbo); save its data as CSV in the VBOX tools"));
  find_header(*table, wanted);
  if (has_number(table->columns, table->layout.delimiter))
    throw std::invalid_argument(
        fmt::format("{}:{}: holds numbers where the names of the columns should be; write them as "
                    "the first line",
                    path, table->layout.header_line));
  return table;
}

using Tables = std::vector<std::unique_ptr<OpenTable>>;

/// The table and the name of the column in its header.
std::pair<std::size_t, std::string> locate(const Tables& tables, const std::string& column,
                                           std::string_view what) {
  std::optional<std::pair<std::size_t, std::string>> found;
  std::vector<std::string> all;
  for (std::size_t i = 0; i < tables.size(); ++i) {
    all.insert(all.end(), tables[i]->columns.begin(), tables[i]->columns.end());
    const auto names = matches(*tables[i], column);
    if (names.size() > 1)
      throw std::invalid_argument(fmt::format("{}: column {} may be {}; write the unit, too",
                                              tables[i]->path, tools::quoted(column),
                                              fmt::join(names, ", ")));
    if (names.empty()) continue;
    if (found)
      throw std::invalid_argument(
          fmt::format("column {} is in {} and in {}; name its table too: {}:{}",
                      tools::quoted(column), tables[found->first]->path, tables[i]->path,
                      std::filesystem::path(tables[i]->path).filename().string(), names.front()));
    found.emplace(i, names.front());
  }
  if (found) return *found;
  throw std::invalid_argument(fmt::format(
      "{}: no column {}{}{}",
      tables.size() == 1 ? tables[0]->path : counted(tables.size(), "table"), tools::quoted(column),
      what, nearest_hint(column.substr(column.find(':') + 1), all)));
}

std::size_t need(OpenTable& table, const std::string& column) {
  const auto found = std::ranges::find(table.needed, column);
  const auto index = static_cast<std::size_t>(found - table.needed.begin());
  if (found == table.needed.end()) table.needed.push_back(column);
  return index;
}

std::string_view unit_of(const OpenTable& table, const std::string& column) {
  const auto index =
      static_cast<std::size_t>(std::ranges::find(table.columns, column) - table.columns.begin());
  const std::string_view unit = split_unit(column).unit;
  return unit.empty() && index < table.units.size() ? table.units[index] : unit;
}

/// Named for this table, else the usual one.
TimeColumn time_of(const OpenTable& table, const ColumnMap& map) {
  for (TimeColumn time : map.times) {
    const bool is_here = std::ranges::all_of(time.columns, [&](std::string& column) {
      const auto names = matches(table, column);
      if (!names.empty()) column = names.front();
      return !names.empty();
    });
    if (is_here) return time;
  }
  if (auto time = usual_time(table.columns)) return *time;
  throw std::invalid_argument(
      fmt::format("{}: none of its columns is surely the time; name it with --time COLUMN: {}",
                  table.path, fmt::join(table.columns, ", ")));
}

/// Of the current row; nothing where it is missing.
std::optional<std::int64_t> time_in(const CsvReader& reader, std::size_t column, TimeUnit& unit) {
  const std::string_view text = reader.text(column);
  if (is_missing(text)) return std::nullopt;
  if (unit == TimeUnit::unstated) unit = unit_by_size(text);
  const auto time = parse_time(std::string(text), unit);
  if (!time)
    reader.fail(column, tools::quoted(text) +
                            " is not a time; correct the row, or state the unit: --time "
                            "'COLUMN,unit=ms' (s, ms, us, ns, hhmmss)");
  return time;
}

/// 101559.9 and 101600.1 are 0.2 s apart as times of day.
bool jumps_like_times_of_day(const TableRows& rows) {
  constexpr std::int64_t minute_ns = 60'000'000'000, hundred_ns = 100'000'000'000;
  return std::ranges::adjacent_find(rows.times_ns, [](std::int64_t one, std::int64_t next) {
           return one % hundred_ns < minute_ns && one / hundred_ns + 1 == next / hundred_ns &&
                  next - one > hundred_ns - minute_ns &&
                  next - one < hundred_ns - minute_ns + 2'000'000'000;
         }) != rows.times_ns.end();
}

/// Times that are no dates may be in any unit.
void require_plausible(const TableRows& rows) {
  constexpr std::int64_t first_date_ns = 900'000'000'000'000'000;
  if (rows.times_ns.size() < 3 || rows.times_ns.front() > first_date_ns) return;
  const double step = static_cast<double>(rows.times_ns.back() - rows.times_ns.front()) * 1e-9 /
                      static_cast<double>(rows.times_ns.size() - 1);
  if (jumps_like_times_of_day(rows))
    throw std::invalid_argument(fmt::format(
        "{}: read as seconds, the time jumps by 40 s where a minute ends; for times of day: "
        "--time '{},unit=hhmmss'",
        rows.name, rows.time_column));
  if (step > 1e-5 && step < 1.0) return;
  throw std::invalid_argument(
      fmt::format("{}: read as seconds, its rows are {:g} s apart; state the unit of the time: "
                  "--time '{},unit=ms' (s, ms, us, ns, hhmmss)",
                  rows.name, step, rows.time_column));
}

TableRows read_rows(OpenTable& table, const ColumnMap& map, std::vector<std::string>& warnings) {
  constexpr double missing = std::numeric_limits<double>::quiet_NaN();
  const TimeColumn time = time_of(table, map);
  const std::size_t seconds = need(table, time.columns.front());
  const std::size_t nanoseconds = need(table, time.columns.back());
  TimeUnit unit = nanoseconds != seconds ? TimeUnit::s : time.unit;
  if (unit == TimeUnit::unstated) unit = time_unit(unit_of(table, time.columns.front()));
  if (unit == TimeUnit::unstated) unit = unit_in_name(time.columns.front());
  const bool is_guess = unit == TimeUnit::unstated;
  TableRows rows{.name = table.path, .time_column = time.columns.front()};
  CsvReader reader(table.text, table.path, table.needed, {}, LastLine::keep_whole, table.layout);
  if (!table.units.empty()) static_cast<void>(reader.next());
  std::size_t without_time = 0;
  while (reader.next()) {
    auto time_ns = time_in(reader, seconds, unit);
    if (!time_ns) {
      ++without_time;
      continue;
    }
    if (nanoseconds != seconds) {
      TimeUnit unit_of_part = TimeUnit::ns;
      const auto part = time_in(reader, nanoseconds, unit_of_part);
      if (!part || *part < 0 || *part >= 1'000'000'000)
        reader.fail(nanoseconds, "is no number of nanoseconds within a second");
      *time_ns += *part;
    }
    if (!rows.times_ns.empty() && *time_ns < rows.times_ns.back())
      throw std::invalid_argument(fmt::format(
          "{}: the time runs back by {:.6f} s; sort the rows by {}, or cut the table there",
          reader.place(), static_cast<double>(rows.times_ns.back() - *time_ns) * 1e-9,
          tools::quoted(rows.time_column)));
    rows.times_ns.push_back(*time_ns);
    for (std::size_t i = 0; i < table.mapped.size(); ++i) {
      MappedColumn& column = *table.mapped[i];
      const std::string_view cell = reader.text(table.indices[i]);
      if (is_missing(cell)) {
        column.values.push_back(missing);
      } else if (column.role == "camera.arrival") {
        const auto arrival = time_in(reader, table.indices[i], column.time_unit);
        column.values.push_back(static_cast<double>(*arrival - *time_ns) * 1e-9);
      } else if (const auto value = number_in(cell, table.layout.delimiter)) {
        column.values.push_back(column.factor * *value + column.offset);
      } else {
        reader.fail(table.indices[i],
                    tools::quoted(cell) + " is not a number; correct the cell, or leave it empty");
      }
    }
  }
  if (rows.times_ns.empty()) throw std::invalid_argument(table.path + ": has no rows");
  if (is_guess && unit == TimeUnit::s) require_plausible(rows);
  warnings.insert(warnings.end(), reader.warnings().begin(), reader.warnings().end());
  if (without_time > 0)
    warnings.push_back(
        fmt::format("{}: {} without a time left out", table.path, counted(without_time, "row")));
  return rows;
}

}  // namespace

std::vector<TableRows> read_tables(ColumnMap& map, const ReportProgress& report,
                                   std::vector<std::string>& warnings) {
  if (map.tables.empty())
    throw std::invalid_argument("no table: name its file, or write tables = [...] in the --map");
  std::vector<std::string> wanted;
  for (const auto* columns : {&map.sensors, &map.camera, &map.truth})
    for (const MappedColumn& column : *columns)
      if (!column.name.empty()) wanted.push_back(column.name);
  for (const TimeColumn& time : map.times)
    wanted.insert(wanted.end(), time.columns.begin(), time.columns.end());

  Tables tables;
  for (const std::string& path : map.tables) tables.push_back(open_table(path, wanted));
  for (const TimeColumn& time : map.times)
    if (std::ranges::none_of(tables, [&](const auto& table) {
          return !matches(*table, time.columns.front()).empty();
        }))
      static_cast<void>(locate(tables, time.columns.front(), " for the time"));
  for (auto* columns : {&map.sensors, &map.camera, &map.truth})
    for (MappedColumn& column : *columns) {
      if (column.name.empty()) continue;
      const auto [index, name] = locate(tables, column.name, "");
      OpenTable& table = *tables[index];
      read_keys(column, unit_of(table, name), map.file);
      column.table = index;
      column.place = fmt::format("{}: {}", table.path, name);
      table.mapped.push_back(&column);
      table.indices.push_back(need(table, name));
    }
  std::vector<TableRows> rows;
  for (const auto& table : tables) {
    if (report) report(table->path);
    rows.push_back(table->mapped.empty() ? TableRows{} : read_rows(*table, map, warnings));
  }
  return rows;
}

}  // namespace odomd::tools
