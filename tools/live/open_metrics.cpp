#include "tools/live/status_text.hpp"

#include <fmt/format.h>
#include <array>
#include <span>

#include "tools/live/status_value.hpp"

namespace odomd::tools {
namespace {

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
