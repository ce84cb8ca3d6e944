#include "tools/live/status_value.hpp"

#include <algorithm>
#include <array>
#include <span>

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

/// One metric family. If the value is an object or a word, its samples get a label.
struct Family {
  std::string_view path;  ///< path of the value; a value in _us becomes seconds
  std::string_view name;
  std::string_view type;
  std::string_view label;  ///< label for an object's keys or for the word
};

constexpr std::array of_daemon{
    Family{"version", "odom_build_info", "gauge", "version"},
    Family{"uptime_s", "odom_uptime_seconds", "gauge", ""},
    Family{"mode", "odom_mode", "gauge", "mode"},
    Family{"conditions", "odom_condition", "gauge", "condition"},
    Family{"pose/age_s", "odom_pose_age_seconds", "gauge", ""},
    Family{"pose/vx", "odom_forward_speed_meters_per_second", "gauge", ""},
    Family{"pose/vy", "odom_lateral_speed_meters_per_second", "gauge", ""},
    Family{"pose/yaw_rate", "odom_yaw_rate_radians_per_second", "gauge", ""},
    Family{"pose/sigma_x", "odom_sigma_x_meters", "gauge", ""},
    Family{"pose/sigma_y", "odom_sigma_y_meters", "gauge", ""},
    Family{"pose/sigma_yaw", "odom_sigma_yaw_radians", "gauge", ""},
    Family{"pose/reset_count", "odom_pose_jumps", "counter", ""},
    Family{"beat/ticks", "odom_ticks", "counter", ""},
    Family{"beat/missed", "odom_ticks_missed", "counter", ""},
    Family{"beat/overruns", "odom_ticks_overrun", "counter", ""},
    Family{"beat/wakeup_us", "odom_tick_lateness_seconds", "gauge", "statistic"},
    Family{"beat/execution_us", "odom_tick_duration_seconds", "gauge", "statistic"},
    Family{"camera/messages", "odom_camera_messages", "counter", ""},
    Family{"events_dropped", "odom_events_dropped", "counter", ""}};
constexpr std::array of_source{
    Family{"healthy", "odom_source_healthy", "gauge", ""},
    Family{"age_s", "odom_source_age_seconds", "gauge", ""},
    Family{"innovations/mean_nis", "odom_source_mean_nis", "gauge", ""},
    Family{"innovations/dimension", "odom_source_dimension", "gauge", ""},
    Family{"verdicts", "odom_source_samples", "counter", "verdict"}};
constexpr std::array of_bus{Family{"link", "odom_can_link", "gauge", "link"},
                            Family{"received", "odom_can_frames", "counter", ""},
                            Family{"lost", "odom_can_frames_lost", "counter", ""},
                            Family{"error_frames", "odom_can_error_frames", "counter", ""},
                            Family{"bus_offs", "odom_can_bus_offs", "counter", ""}};

std::string label(std::string_view name, const std::string& value) {
  std::string text;
  for (const char c : value) {
    if (c == '\\' || c == '"') text += '\\';
    text += c == '\n' ? std::string{"\\n"} : std::string{c};
  }
  return fmt::format("{}=\"{}\"", name, text);
}

std::string samples(const Family& family, const Json& value, const std::string& labels) {
  const auto with = [&](const std::string& content) {
    return labels + (labels.empty() ? "" : ",") + label(family.label, content);
  };
  std::string text;
  if (value.is_string()) return samples(family, true, with(value.get<std::string>()));
  if (value.is_object())
    for (const auto& [key, one] : value.items()) text += samples(family, one, with(key));
  if (value.is_array())
    for (const Json& one : value) text += samples(family, one, labels);
  if (value.is_structured() || value.is_null()) return text;
  const double number = value.is_boolean() ? (value.get<bool>() ? 1 : 0) : value.get<double>();
  return fmt::format("{}{}{} {}\n", family.name, family.type == "counter" ? "_total" : "",
                     labels.empty() ? "" : '{' + labels + '}',
                     family.path.ends_with("_us") ? 1e-6 * number : number);
}

/// `elements`: the document alone, or the elements of an array, with their names as `name_label`.
void append(std::string& text, std::span<const Family> families,
            const std::vector<StatusValue>& elements, std::string_view name_label) {
  for (const Family& family : families) {
    std::string all;
    for (const StatusValue& element : elements)
      if (!element["configured"].exists() || element["configured"].is_true())
        all += samples(family, element[family.path].json(),
                       name_label.empty() ? "" : label(name_label, element["name"].text()));
    if (!all.empty()) text += fmt::format("# TYPE {} {}\n{}", family.name, family.type, all);
  }
}

}  // namespace

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

std::string open_metrics(const std::optional<Json>& status) {
  std::string text = fmt::format("# TYPE odom_up gauge\nodom_up {:d}\n", status.has_value());
  if (status) {
    const StatusValue document{*status};
    append(text, of_daemon, {document}, "");
    append(text, of_source, document["sources"].elements(), "source");
    append(text, of_bus, document["can"].elements(), "bus");
  }
  return text + "# EOF\n";
}

}  // namespace odomd::tools
