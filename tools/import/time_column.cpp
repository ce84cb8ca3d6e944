#include "tools/import/column_map.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdlib>
#include <ctime>
#include <stdexcept>
#include <utility>

#include <fmt/format.h>

namespace odomd::tools {
namespace {

constexpr std::int64_t second_ns = 1'000'000'000;
constexpr std::int64_t latest_ns = 4'600'000'000LL * second_ns;  // as in odom's own files

constexpr std::array<std::string_view, 6> units{"", "s", "ms", "us", "ns", "hhmmss"};

/// In order of preference.
constexpr std::array<std::string_view, 7> usual_names{
    "header.stamp", "stamp", "__time", "time", "t", "timestamp", "rosbagtimestamp"};
constexpr std::array<std::pair<std::string_view, std::string_view>, 3> usual_pairs{
    {{"sec", "nanosec"}, {"secs", "nsecs"}, {"sec", "nsec"}}};

std::string lower(std::string_view text) {
  std::string result(text);
  for (char& c : result)
    if (c >= 'A' && c <= 'Z') c = static_cast<char>(c - 'A' + 'a');
  return result;
}

/// "time" for "Time (ms)", "field.time" and "%time_ms".
std::string plain_name(std::string_view column) {
  std::string name = lower(split_unit(column).name);
  if (name.starts_with("field.")) name.erase(0, 6);
  if (const auto end = name.rfind('_');
      end != std::string::npos && time_unit(name.substr(end + 1)) != TimeUnit::unstated)
    name.resize(end);
  return name;
}

/// Parses a time of day, with or without a date. Ignores a zone, which only shifts all times.
std::optional<std::int64_t> clock_ns(std::string text) {
  std::ranges::replace(text, 'T', ' ');
  std::tm time{.tm_mday = 1, .tm_year = 70};
  const bool has_date = text.find('-') < text.find(':');
  const char* rest = ::strptime(text.c_str(), has_date ? "%Y-%m-%d %H:%M:%S" : "%H:%M:%S", &time);
  if (rest == nullptr) return std::nullopt;
  std::string_view fraction(rest);
  fraction = fraction.substr(0, fraction.find_first_of("Z+-"));
  if (!fraction.empty() && !fraction.starts_with('.')) return std::nullopt;
  const auto part = parse_seconds("0" + std::string(fraction));
  if (!part) return std::nullopt;
  return ::timegm(&time) * second_ns + *part;
}

/// The unit that makes the time a date of this century, otherwise seconds.
TimeUnit unit_by_size(std::string_view text) {
  const double size = std::abs(std::strtod(std::string(text).c_str(), nullptr));
  return size < 1e11   ? TimeUnit::s
         : size < 1e14 ? TimeUnit::ms
         : size < 1e17 ? TimeUnit::us
                       : TimeUnit::ns;
}

/// Empty if the text is not a time. With colons the unit does not matter: "10:21:07.25",
/// "2026-01-16T10:21:07.25Z".
std::optional<std::int64_t> parse_time(std::string text, TimeUnit unit) {
  std::ranges::replace(text, ',', '.');
  std::optional<std::int64_t> time;
  if (text.find(':') != std::string::npos) {
    time = clock_ns(text);
  } else if (unit == TimeUnit::hhmmss) {
    const std::size_t whole = std::min(text.find('.'), text.size());
    text.insert(0, 6 - std::min<std::size_t>(whole, 6), '0');
    time = clock_ns(text.insert(4, ":").insert(2, ":"));
  } else {
    const std::array<std::string_view, 5> exponents{"", "", "e-3", "e-6", "e-9"};
    time = parse_seconds(text.append(exponents[static_cast<std::size_t>(unit)]));
  }
  return time && std::abs(*time) <= latest_ns ? time : std::nullopt;
}

/// Whether there is a step like 101559.9 to 101600.1, which is 0.2 s for times of day.
bool jumps_like_times_of_day(const std::vector<std::int64_t>& times_ns) {
  constexpr std::int64_t minute_ns = 60 * second_ns, hundred_ns = 100 * second_ns;
  return std::ranges::adjacent_find(times_ns, [](std::int64_t one, std::int64_t next) {
           return one % hundred_ns < minute_ns && one / hundred_ns + 1 == next / hundred_ns &&
                  next - one > hundred_ns - minute_ns &&
                  next - one < hundred_ns - minute_ns + 2 * second_ns;
         }) != times_ns.end();
}

}  // namespace

TimeUnit time_unit(std::string_view text) {
  const auto found = std::ranges::find(units, lower(text));
  return found == units.end() ? TimeUnit::unstated : static_cast<TimeUnit>(found - units.begin());
}

NameAndUnit split_unit(std::string_view column) {
  column.remove_prefix(std::min(column.find_first_not_of("#% "), column.size()));
  if (column.empty() || (column.back() != ')' && column.back() != ']')) return {column, {}};
  const auto open = column.rfind(column.back() == ')' ? '(' : '[');
  if (open == std::string_view::npos || open == 0) return {column, {}};
  const std::string_view name = column.substr(0, open);
  return {name.substr(0, name.find_last_not_of(' ') + 1),
          column.substr(open + 1, column.size() - open - 2)};
}

bool is_missing(std::string_view cell) {
  constexpr std::array<std::string_view, 14> texts{"",     "nan", "NaN",  "null",     "NULL",
                                                   "None", "n/a", "N/A",  "na",       "NA",
                                                   "-",    "--",  "#N/A", "-nan(ind)"};
  return std::ranges::find(texts, cell) != texts.end();
}

std::optional<TimeColumn> usual_time(const std::vector<std::string>& columns) {
  for (const std::string& column : columns)
    for (const auto& [seconds, nanoseconds] : usual_pairs) {
      if (!column.ends_with(seconds) || column.ends_with(nanoseconds)) continue;
      const std::string other =
          column.substr(0, column.size() - seconds.size()) + std::string(nanoseconds);
      if (std::ranges::find(columns, other) != columns.end()) return TimeColumn{{column, other}};
    }
  for (const std::string_view usual : usual_names)
    if (const auto found = std::ranges::find(columns, usual, plain_name); found != columns.end())
      return TimeColumn{{*found}};
  return std::nullopt;
}

void take_unit(TimeColumn& time, std::string_view unit_of_table) {
  const auto [name, unit] = split_unit(time.columns.front());
  for (const std::string_view stated :
       {unit_of_table, unit.empty() ? name.substr(name.rfind('_') + 1) : unit})
    if (time.unit == TimeUnit::unstated) time.unit = time_unit(stated);
}

std::optional<std::int64_t> time_in(const CsvReader& reader, std::size_t column, TimeUnit& unit) {
  const std::string_view text = reader.text(column);
  if (is_missing(text)) return std::nullopt;
  if (unit == TimeUnit::unstated) unit = unit_by_size(text);
  const auto time = parse_time(std::string(text), unit);
  if (!time)
    reader.fail(column, quoted(text) +
                            " is not a time; correct the row, or state the unit: --time "
                            "'COLUMN,unit=ms' (s, ms, us, ns, hhmmss)");
  return time;
}

std::optional<std::int64_t> time_in(const CsvReader& reader, TimeColumn& time) {
  const auto whole = time_in(reader, 0, time.unit);
  if (!whole || time.columns.size() == 1) return whole;
  TimeUnit unit = TimeUnit::ns;
  const auto part = time_in(reader, 1, unit);
  if (!part || *part < 0 || *part >= second_ns)
    reader.fail(1, "is no number of nanoseconds within a second");
  return *whole + *part;
}

void require_seconds(const std::vector<std::int64_t>& times_ns, const std::string& table,
                     const std::string& column) {
  constexpr std::int64_t first_date_ns = 900'000'000 * second_ns;
  if (times_ns.size() < 3 || times_ns.front() > first_date_ns) return;
  const double step = static_cast<double>(times_ns.back() - times_ns.front()) * 1e-9 /
                      static_cast<double>(times_ns.size() - 1);
  if (jumps_like_times_of_day(times_ns))
    throw std::invalid_argument(fmt::format(
        "{}: read as seconds, the time jumps by 40 s where a minute ends; for times of day: "
        "--time '{},unit=hhmmss'",
        table, column));
  if (step <= 1e-5 || step >= 1.0)
    throw std::invalid_argument(
        fmt::format("{}: read as seconds, its rows are {:g} s apart; state the unit of the time: "
                    "--time '{},unit=ms' (s, ms, us, ns, hhmmss)",
                    table, step, column));
}

}  // namespace odomd::tools
