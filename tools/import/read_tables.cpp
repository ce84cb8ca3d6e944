#include "tools/import/read_tables.hpp"

#include <algorithm>
#include <limits>
#include <memory>
#include <optional>
#include <stdexcept>

#include <fmt/format.h>

#include "base/nearest_name.hpp"
#include "tools/cli/csv.hpp"

namespace odomd::tools {
namespace {

constexpr double missing = std::numeric_limits<double>::quiet_NaN();

/// A column's name without the table's before it: "gyro_z" of "imu.csv:gyro_z" in imu.csv; nothing
/// if it is of another table.
std::optional<std::string> name_in(const std::string& file, const std::string& column,
                                   const std::vector<std::string>& files) {
  const auto names = [&column](const std::string& path) {
    const std::filesystem::path file_path(path);
    std::size_t length = 0;
    for (const std::string& name : {path, file_path.filename().string(), file_path.stem().string()})
      if (column.starts_with(name + ':')) length = std::max(length, name.size() + 1);
    return length;
  };
  if (const std::size_t length = names(file); length > 0) return column.substr(length);
  const bool others = std::ranges::any_of(files, [&](const auto& path) { return names(path) > 0; });
  return others ? std::nullopt : std::optional(column);
}

class Reader {
 public:
  Reader(ColumnMap& map, const ReportProgress& report) : map_(map), report_(report) {}

  Tables read() {
    if (map_.tables.empty())
      throw std::invalid_argument("no table: name its file, or write tables = [...] in the --map");
    for (const std::string& file : map_.tables)
      tables_.push_back(std::make_unique<CsvTable>(file, wanted_in(file)));
    for (const TimeColumn& time : map_.times)
      if (std::ranges::none_of(tables_,
                               [&](const auto& table) { return in(*table, time).has_value(); }))
        throw std::invalid_argument(fmt::format("{}: no column {} for the time{}", where(),
                                                tools::quoted(time.columns.front()),
                                                nearest_columns(time.columns.front())));
    Tables result;
    result.rows.resize(tables_.size());
    const auto locate_all = [&](auto& columns, std::vector<Place>& places) {
      for (auto& column : columns) {
        if (column.column.empty() || is_constant(column)) {
          places.push_back({});
          continue;
        }
        const Place place = locate(column.column);
        use_unit_of_table(column, tables_[place.table]->unit(place.column), place.name);
        add(result.rows[place.table], place.column, column);
        places.push_back(place);
      }
    };
    locate_all(map_.sensors, result.sensors);
    locate_all(map_.camera, result.camera);
    locate_all(map_.truth, result.truth);
    for (std::size_t i = 0; i < tables_.size(); ++i)
      if (!result.rows[i].values.empty() || !result.rows[i].value_times_ns.empty())
        read_rows(*tables_[i], result.rows[i]);
    return result;
  }

 private:
  static bool is_constant(const SensorColumn&) { return false; }
  static bool is_constant(const PoseColumn& column) { return column.constant.has_value(); }

  std::vector<std::string> wanted_in(const std::string& file) const {
    std::vector<std::string> wanted;
    const auto want = [&](const std::string& column) {
      if (const auto name = name_in(file, column, map_.tables)) wanted.push_back(*name);
    };
    for (const SensorColumn& column : map_.sensors) want(column.column);
    for (const auto* columns : {&map_.camera, &map_.truth})
      for (const PoseColumn& column : *columns)
        if (!column.constant) want(column.column);
    for (const TimeColumn& time : map_.times)
      for (const std::string& column : time.columns) want(column);
    return wanted;
  }

  Place locate(const std::string& column) const {
    std::optional<Place> found;
    for (std::size_t i = 0; i < tables_.size(); ++i) {
      const auto name = name_in(map_.tables[i], column, map_.tables);
      const auto index = name ? tables_[i]->find(*name) : std::nullopt;
      if (!index) continue;
      if (found)
        throw std::invalid_argument(
            fmt::format("column {} is in {} and in {}; name its table too: {}:{}",
                        tools::quoted(column), map_.tables[found->table], map_.tables[i],
                        std::filesystem::path(map_.tables[i]).filename().string(), *name));
      found = Place{i, *index, fmt::format("{}: {}", map_.tables[i], *name)};
    }
    if (found) return *found;
    throw std::invalid_argument(
        fmt::format("{}: no column {}{}", where(), tools::quoted(column), nearest_columns(column)));
  }

  std::string where() const {
    return map_.tables.size() == 1 ? map_.tables.front() : fmt::format("{} tables", tables_.size());
  }

  std::string nearest_columns(const std::string& column) const {
    std::vector<std::string> all;
    for (std::size_t i = 0; i < tables_.size(); ++i)
      if (name_in(map_.tables[i], column, map_.tables))
        for (const std::string& name : tables_[i]->columns())
          if (!name.empty()) all.push_back(name);
    std::string text;
    const std::string own = column.substr(column.find(':') + 1);
    for (int i = 0; i < 3 && !all.empty(); ++i) {
      const std::string nearest(nearest_name(own, all));
      text += (text.empty() ? "; the nearest are " : ", ") + tools::quoted(nearest);
      std::erase(all, nearest);
    }
    return text;
  }

  static void add(TableRows& rows, std::size_t column, const SensorColumn&) { rows.values[column]; }
  void add(TableRows& rows, std::size_t column, const PoseColumn& pose) {
    if (pose.quantity == Quantity::time) {
      rows.value_times_ns[column];
      arrival_ = {{fmt::format("#{}", column + 1)}, pose.time_unit};
    } else {
      rows.values[column];
    }
  }

  /// A time column with its names in this table; nothing if it is not there.
  std::optional<TimeColumn> in(const CsvTable& table, TimeColumn time) const {
    for (std::string& column : time.columns) {
      const auto name = name_in(table.name(), column, map_.tables);
      if (!name || !table.find(*name)) return std::nullopt;
      column = *name;
    }
    return time;
  }

  TimeColumn time_of(const CsvTable& table) const {
    for (const TimeColumn& time : map_.times)
      if (auto own = in(table, time)) return *std::move(own);
    return usual_time(table);
  }

  void read_rows(CsvTable& table, TableRows& rows) const {
    rows.name = table.name();
    TimeReader time(table, time_of(table));
    rows.time_column = time.column_name();
    std::optional<TimeReader> arrival;
    if (!rows.value_times_ns.empty()) arrival.emplace(table, arrival_);
    while (table.next()) {
      const auto time_ns = time.time_ns();
      if (!time_ns) {
        ++rows.without_time;
        continue;
      }
      if (!rows.times_ns.empty() && *time_ns < rows.times_ns.back())
        throw std::invalid_argument(
            fmt::format("{}: the time runs back by {:.6f} s; sort the rows by {}, or cut the table "
                        "there",
                        table.place(), static_cast<double>(rows.times_ns.back() - *time_ns) * 1e-9,
                        tools::quoted(time.column_name())));
      rows.times_ns.push_back(*time_ns);
      for (auto& [column, values] : rows.values)
        values.push_back(table.number(column).value_or(missing));
      if (arrival)
        rows.value_times_ns.begin()->second.push_back(arrival->time_ns().value_or(no_time));
      constexpr std::size_t rows_per_report = 1U << 16U;
      if (rows.times_ns.size() % rows_per_report == 0 && report_)
        report_(fmt::format("{}: {:.0f} %", table.name(), 100.0 * table.progress()));
    }
    if (rows.times_ns.empty()) throw std::invalid_argument(table.name() + ": has no rows");
    if (time.is_guessed()) require_plausible(rows);
  }

  /// Times that are no dates may be in any unit.
  static void require_plausible(const TableRows& rows) {
    if (rows.times_ns.size() < 3) return;
    const double step = static_cast<double>(rows.times_ns.back() - rows.times_ns.front()) * 1e-9 /
                        static_cast<double>(rows.times_ns.size() - 1);
    if (step > 1e-5 && step < 1.0) return;
    throw std::invalid_argument(
        fmt::format("{}: read as seconds, its rows are {:g} s apart; state the unit of the time: "
                    "--time '{},unit=ms' (s, ms, us, ns, hhmmss)",
                    rows.name, step, rows.time_column));
  }

  ColumnMap& map_;
  const ReportProgress& report_;
  std::vector<std::unique_ptr<CsvTable>> tables_;
  TimeColumn arrival_;
};

}  // namespace

Tables read_tables(ColumnMap& map, const ReportProgress& report) {
  return Reader(map, report).read();
}

}  // namespace odomd::tools
