#include "tools/live/status_value.hpp"

#include <algorithm>
#include <array>

#include <fmt/format.h>

#include "tools/cli/text.hpp"

namespace odomd::tools {
namespace {

const Json nothing;

const Json& member(const Json& object, const std::string& key) {
  const auto found = object.find(key);
  return found == object.end() ? nothing : *found;
}

const Json& element_named(const Json& array, const Json& name) {
  const auto found = std::find_if(array.begin(), array.end(), [&](const Json& element) {
    return member(element, "name") == name;
  });
  return found == array.end() ? nothing : *found;
}

double uptime_of(const Json& document) {
  const Json& uptime = member(document, "uptime_s");
  return uptime.is_number() ? uptime.get<double>() : 0.0;
}

std::uint64_t count_of(const Json& value) {
  if (!value.is_object()) return value.is_null() ? 0 : value.get<std::uint64_t>();
  std::uint64_t total = 0;
  for (const Json& part : value) total += part.get<std::uint64_t>();
  return total;
}

}  // namespace

std::string hyphenated(std::string name) {
  std::ranges::replace(name, '_', '-');
  return name;
}

StatusValue::StatusValue() : StatusValue(nothing, nothing, 0.0) {}

StatusValue::StatusValue(const Json& now, const std::optional<Json>& before)
    : StatusValue(now, nothing, uptime_of(now)) {
  if (!before || member(*before, "instance") != member(now, "instance")) return;
  if (!(seconds_ > uptime_of(*before))) return;
  before_ = &*before;
  seconds_ -= uptime_of(*before);
}

StatusValue StatusValue::operator[](std::string_view path) const {
  const auto slash = path.find('/');
  const std::string key{path.substr(0, slash)};
  const StatusValue value{member(*now_, key), member(*before_, key), seconds_};
  return slash == std::string_view::npos ? value : value[path.substr(slash + 1)];
}

std::vector<StatusValue> StatusValue::elements() const {
  std::vector<StatusValue> all;
  for (const Json& element : *now_)
    all.push_back({element, element_named(*before_, member(element, "name")), seconds_});
  return all;
}

StatusValue StatusValue::named(std::string_view name) const {
  return {element_named(*now_, name), element_named(*before_, name), seconds_};
}

double StatusValue::value(double otherwise) const {
  return exists() ? now_->get<double>() : otherwise;
}

std::uint64_t StatusValue::count() const {
  return count_of(*now_);
}

std::string StatusValue::text() const {
  if (!exists()) return "-";
  return now_->is_number() ? std::to_string(count()) : now_->get<std::string>();
}

std::string StatusValue::number(int decimals, double factor) const {
  return exists() ? fixed(factor * value(), decimals) : "-";
}

std::string StatusValue::significant() const {
  return exists() ? fmt::format("{:#.3g}", value()) : "-";
}

std::string StatusValue::counted(std::string_view noun) const {
  return exists() ? tools::counted(count(), noun) : fmt::format("- {}s", noun);
}

std::string StatusValue::duration() const {
  return exists() ? duration_in_words(value()) : "never";
}

std::string StatusValue::hexadecimal() const {
  return exists() ? fmt::format("0x{:X}", count()) : "-";
}

std::string StatusValue::rate() const {
  const std::uint64_t before = count_of(*before_);
  if (!exists() || !(seconds_ > 0.0) || count() < before) return "-";
  return fixed(static_cast<double>(count() - before) / seconds_, 1);
}

std::string StatusValue::nonzero(std::initializer_list<std::string_view> without) const {
  std::string text;
  for (const auto& [name, value] : now_->items())
    if (std::ranges::find(without, name) == without.end() && count_of(value) > 0)
      text += fmt::format("{}{} {}", text.empty() ? "" : ", ", count_of(value), name);
  return text;
}

std::string duration_in_words(double seconds) {
  if (seconds < 1.0) return fixed(1e3 * seconds, 1) + " ms";
  if (seconds < 120.0) return fixed(seconds, 1) + " s";
  const auto minutes = static_cast<long>(seconds / 60.0);
  if (minutes < 120) return fmt::format("{} min", minutes);
  return fmt::format("{} h {:02} min", minutes / 60, minutes % 60);
}

std::string source_state(const StatusValue& source) {
  if (source["healthy"].is_true())
    return source["inconsistent"].is_true() ? "inconsistent" : "fine";
  // Missing and impossible values come before other findings.
  constexpr std::array first{"timed_out", "failed_protection", "out_of_range", "non_finite",
                             "frozen"};
  std::string flag = source["flag"].text();
  std::string wiring = source["wiring"].text();
  std::ranges::replace(wiring, '_', ' ');
  if (wiring != "-" && wiring != "ok" && std::ranges::find(first, flag) == first.end())
    return "miswired: " + wiring;
  if (flag == "-" || flag == "ok" || flag == "timed_out") return "overdue";
  std::ranges::replace(flag, '_', ' ');
  return flag;
}

std::string nis_by_expectation(const StatusValue& source) {
  const double dimension = source["innovations/dimension"].value();
  return dimension > 0.0 ? source["innovations/mean_nis"].number(2, 1.0 / dimension) : "-";
}

}  // namespace odomd::tools
