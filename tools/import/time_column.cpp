#include "tools/import/time_column.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdlib>
#include <ctime>
#include <utility>

#include "tools/cli/csv.hpp"

namespace odomd::tools {
namespace {

constexpr std::int64_t second_ns = 1'000'000'000;
constexpr std::int64_t latest_ns = 4'600'000'000LL * second_ns;  // as in odom's own files

constexpr std::array<std::string_view, 6> units{"", "s", "ms", "us", "ns", "hhmmss"};

/// The best first.
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

/// "time" of "Time (ms)", "field.time" and "%time_ms".
std::string plain_name(std::string_view column) {
  std::string name = lower(split_unit(column).name);
  if (name.starts_with("field.")) name.erase(0, 6);
  if (const auto end = name.rfind('_');
      end != std::string::npos && time_unit(name.substr(end + 1)) != TimeUnit::unstated)
    name.resize(end);
  return name;
}

/// A zone is left out: it only shifts all times.
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

TimeUnit unit_in_name(std::string_view column) {
  const auto [name, unit] = split_unit(column);
  return time_unit(unit.empty() ? name.substr(name.rfind('_') + 1) : unit);
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

TimeUnit unit_by_size(std::string_view text) {
  const double size = std::abs(std::strtod(std::string(text).c_str(), nullptr));
  return size < 1e11   ? TimeUnit::s
         : size < 1e14 ? TimeUnit::ms
         : size < 1e17 ? TimeUnit::us
                       : TimeUnit::ns;
}

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

}  // namespace odomd::tools
