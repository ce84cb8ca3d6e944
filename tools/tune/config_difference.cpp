#include "tools/tune/config_difference.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <map>
#include <optional>
#include <set>
#include <sstream>
#include <string_view>

#include "daemon/core/config_toml.hpp"
#include "tools/cli/json_text.hpp"
#include "tools/tune/value_in_force.hpp"

namespace odomd::tools {
namespace {

using Values = std::map<std::string, std::string>;

constexpr std::size_t most_named = 3;

bool matters(std::string_view key) {
  // A recording names its buses as they were called when it was made.
  if (key.ends_with(".bus")) return false;
  // Settings of the search itself do not count.
  if (key == "filter.model") return false;
  constexpr std::array<std::string_view, 9> parts{
      "vehicle.",           "steering.", "can.signals.", "can.e2e.",       "camera.lever_arm",
      "camera.max_latency", "imu.",      "filter.",      "realtime.period"};
  return std::ranges::any_of(parts, [key](std::string_view part) { return key.starts_with(part); });
}

void take(const toml::node& node, const std::string& key, Values& values) {
  if (const toml::table* const table = node.as_table()) {
    for (const auto& [name, inner] : *table)
      take(inner, (key.empty() ? "" : key + '.') + std::string(name.str()), values);
  } else if (const toml::array* const list = node.as_array()) {
    for (std::size_t i = 0; i < list->size(); ++i)
      take((*list)[i], fmt::format("{}[{}]", key, i), values);
  } else if (matters(key)) {
    std::ostringstream text;
    text << toml::node_view<const toml::node>(node);
    values[key] = node.is_number() ? shortest(*node.value<double>()) : text.str();
  }
}

Values values_of(const daemon::Config& config) {
  Values values;
  take(daemon::parse_toml(config.text, config.file), "", values);
  return values;
}

std::string value_of(const Values& values, const daemon::Config& config, const std::string& key) {
  if (const auto found = values.find(key); found != values.end()) return found->second;
  if (const auto value = value_in_force(config, key)) return shortest(*value);
  return "none";
}

}  // namespace

std::string config_difference(const daemon::Config& one, const daemon::Config& other,
                              std::span<const Parameter> tuned) {
  const Values in_one = values_of(one), in_other = values_of(other);
  std::set<std::string> keys;
  for (const Values* values : {&in_one, &in_other})
    for (const auto& [key, value] : *values) keys.insert(key);
  for (const Parameter& parameter : tuned) keys.erase(parameter.key);
  std::string text;
  std::size_t different = 0;
  for (const std::string& key : keys) {
    const std::string here = value_of(in_one, one, key), there = value_of(in_other, other, key);
    if (here == there || ++different > most_named) continue;
    text += fmt::format("{}{} ({}, {})", different == 1 ? "" : ", ", key, here, there);
  }
  if (different > most_named) text += fmt::format(" and {} more", different - most_named);
  return text;
}

}  // namespace odomd::tools
