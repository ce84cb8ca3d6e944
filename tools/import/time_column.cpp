#include "tools/import/time_column.hpp"

#include <algorithm>
#include <array>
#include <charconv>
#include <chrono>
#include <cmath>
#include <stdexcept>
#include <utility>

#include <fmt/format.h>
#include <fmt/ranges.h>

#include "tools/cli/csv.hpp"

namespace odomd::tools {
namespace {

constexpr std::int64_t second_ns = 1'000'000'000;
constexpr std::int64_t latest_ns = 4'600'000'000LL * second_ns;  // as in odom's own files

using Spelling = std::pair<std::string_view, TimeUnit>;
constexpr std::array units{Spelling{"s", TimeUnit::s},        Spelling{"sec", TimeUnit::s},
                           Spelling{"secs", TimeUnit::s},     Spelling{"second", TimeUnit::s},
                           Spelling{"seconds", TimeUnit::s},  Spelling{"ms", TimeUnit::ms},
                           Spelling{"msec", TimeUnit::ms},    Spelling{"us", TimeUnit::us},
                           Spelling{"usec", TimeUnit::us},    Spelling{"\u00B5s", TimeUnit::us},
                           Spelling{"\u03BCs", TimeUnit::us}, Spelling{"ns", TimeUnit::ns},
                           Spelling{"nsec", TimeUnit::ns},    Spelling{"hhmmss", TimeUnit::hhmmss}};

/// Without unit, lower case. The best first: the sensor's own stamp before the recorder's.
constexpr std::array usual_names{"header.stamp", "stamp",     "__time",         "time", "t",
                                 "timestamp",    "t_capture", "rosbagtimestamp"};

std::string lower(std::string_view text) {
  std::string result(text);
  for (char& c : result)
    if (c >= 'A' && c <= 'Z') c = static_cast<char>(c - 'A' + 'a');
  return result;
}

/// "time" and "ms" of "Time (ms)", "time_ms" and "%time_ms".
struct Named {
  std::string name;
  std::string unit;
};

Named named(std::string_view column) {
  const auto [name, unit] = split_unit(column);
  Named result{lower(name), lower(unit)};
  const auto underscore = result.name.rfind('_');
  if (result.unit.empty() && underscore != std::string::npos && underscore > 0 &&
      time_unit(std::string_view(result.name).substr(underscore + 1))) {
    result.unit = result.name.substr(underscore + 1);
    result.name.resize(underscore);
  }
  for (const std::string_view before : {"%", ".", "/", "field."})
    if (result.name.starts_with(before)) result.name.erase(0, before.size());
  return result;
}

/// Columns of seconds and nanoseconds whose names are alike: "header.stamp.sec", ".nanosec".
std::optional<TimeColumn> usual_pair(const CsvTable& table) {
  using Ending = std::pair<std::string_view, std::string_view>;
  for (const std::string& column : table.columns())
    for (const auto& [seconds, nanoseconds] :
         {Ending{"secs", "nsecs"}, Ending{"sec", "nanosec"}, Ending{"sec", "nsec"}}) {
      if (!column.ends_with(seconds) || column.ends_with(nanoseconds)) continue;
      std::string other = column.substr(0, column.size() - seconds.size());
      other += nanoseconds;
      if (std::ranges::find(table.columns(), other) != table.columns().end())
        return TimeColumn{{column, other}};
    }
  return std::nullopt;
}

std::optional<int> digits(std::string_view text) {
  int value = 0;
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
  if (error != std::errc{} || end != text.data() + text.size() || value < 0) return std::nullopt;
  return value;
}

std::optional<std::int64_t> day_ns(std::string_view text) {
  if (text.size() != 10 || text[4] != text[7]) return std::nullopt;
  const auto y = digits(text.substr(0, 4)), m = digits(text.substr(5, 2)),
             d = digits(text.substr(8, 2));
  if (!y || !m || !d) return std::nullopt;
  const std::chrono::year_month_day date{std::chrono::year(*y),
                                         std::chrono::month(static_cast<unsigned>(*m)),
                                         std::chrono::day(static_cast<unsigned>(*d))};
  if (!date.ok()) return std::nullopt;
  return std::chrono::sys_days(date).time_since_epoch().count() * 86'400 * second_ns;
}

/// "10:21:07.25" and "2026-01-16T10:21:07.25Z"; a zone is left out, as it only shifts all times.
std::optional<std::int64_t> clock_ns(std::string_view text) {
  std::int64_t date = 0;
  if (const auto day_end = text.find_first_of("T "); day_end != std::string_view::npos) {
    const auto day = day_ns(text.substr(0, day_end));
    if (!day) return std::nullopt;
    date = *day;
    text.remove_prefix(day_end + 1);
  }
  text = text.substr(0, text.find_first_of("Z+-"));
  const auto colon = text.find(':');
  const auto second = text.find(':', colon + 1);
  if (colon == std::string_view::npos || second == std::string_view::npos) return std::nullopt;
  const auto hours = digits(text.substr(0, colon));
  const auto minutes = digits(text.substr(colon + 1, second - colon - 1));
  const auto seconds = parse_seconds(text.substr(second + 1));
  if (!hours || !minutes || !seconds || *hours > 24 || *minutes > 59) return std::nullopt;
  return date + (*hours * 60LL + *minutes) * 60 * second_ns + *seconds;
}

TimeUnit unit_by_size(std::string_view text) {
  const double size = std::abs(parse_cell(text, ',').value_or(0.0));
  return size < 1e11   ? TimeUnit::s
         : size < 1e14 ? TimeUnit::ms
         : size < 1e17 ? TimeUnit::us
                       : TimeUnit::ns;
}

}  // namespace

std::optional<TimeUnit> time_unit(std::string_view text) {
  const auto found = std::ranges::find(units, lower(text), &Spelling::first);
  return found == units.end() ? std::nullopt : std::optional(found->second);
}

TimeColumn usual_time(const CsvTable& table) {
  if (auto pair = usual_pair(table)) return *pair;
  for (const std::string_view usual : usual_names)
    for (const std::string& column : table.columns())
      if (named(column).name == usual) return {{column}};
  throw std::invalid_argument(
      table.columns().empty()
          ? table.name() +
                ": has no line of column names; say which column is the time: --time '#1'"
          : fmt::format(
                "{}: none of its columns is surely the time; name it with --time COLUMN: {}",
                table.name(), fmt::join(table.columns(), ", ")));
}

TimeReader::TimeReader(const CsvTable& table, const TimeColumn& column)
    : table_(table), unit_(column.unit) {
  for (const std::string& name : column.columns) columns_.push_back(table.find(name).value());
  if (columns_.size() > 1) unit_ = TimeUnit::s;
  if (unit_ == TimeUnit::unstated)
    unit_ = time_unit(table.unit(columns_[0])).value_or(TimeUnit::unstated);
  if (unit_ == TimeUnit::unstated && columns_[0] < table.columns().size())
    unit_ = time_unit(named(table.columns()[columns_[0]]).unit).value_or(TimeUnit::unstated);
}

std::string TimeReader::column_name() const {
  return columns_[0] < table_.columns().size() ? table_.columns()[columns_[0]]
                                               : fmt::format("#{}", columns_[0] + 1);
}

std::optional<std::int64_t> TimeReader::parse(std::string text) const {
  std::ranges::replace(text, ',', '.');
  if (text.find(':') != std::string::npos) return clock_ns(text);
  if (unit_ == TimeUnit::hhmmss) {
    const std::size_t point = std::min(text.find('.'), text.size());
    if (point < 5) text.insert(0, 5 - point, '0');
    const std::size_t seconds = std::min(text.find('.'), text.size()) - 2;
    return clock_ns(fmt::format("{}:{}:{}", text.substr(0, seconds - 2),
                                text.substr(seconds - 2, 2), text.substr(seconds)));
  }
  const std::string_view exponent = unit_ == TimeUnit::ms   ? "e-3"
                                    : unit_ == TimeUnit::us ? "e-6"
                                    : unit_ == TimeUnit::ns ? "e-9"
                                                            : "";
  // A spreadsheet's 1.76E+18 has lost its digits, but not its unit.
  const auto e = text.find_first_of("eE");
  if (e == std::string::npos) return parse_seconds(text.append(exponent));
  const auto own = digits(std::string_view(text).substr(text[e + 1] == '+' ? e + 2 : e + 1));
  if (!own) return std::nullopt;
  const int shift = exponent.empty() ? 0 : exponent[2] - '0';
  return parse_seconds(fmt::format("{}e{}", text.substr(0, e), *own - shift));
}

std::optional<std::int64_t> TimeReader::time_ns() {
  const std::string_view text = table_.cell(columns_[0]);
  if (text.empty()) return std::nullopt;
  if (unit_ == TimeUnit::unstated) {
    unit_ = unit_by_size(text);
    guessed_ = unit_ == TimeUnit::s && std::abs(parse_cell(text, ',').value_or(0.0)) < 9e8;
  }
  auto time = parse(std::string(text));
  if (time && columns_.size() > 1) {
    const auto part = parse_seconds(table_.cell(columns_[1]));
    if (!part || *part % second_ns != 0 || *part / second_ns >= second_ns)
      table_.fail(columns_[1],
                  tools::quoted(table_.cell(columns_[1])) + " is no number of nanoseconds");
    *time += *part / second_ns;
  }
  if (!time || *time > latest_ns || *time < -latest_ns)
    table_.fail(columns_[0], tools::quoted(text) +
                                 " is not a time; correct the row, or state the unit: --time "
                                 "'COLUMN,unit=ms' (s, ms, us, ns, hhmmss)");
  return time;
}

}  // namespace odomd::tools
