#include "tools/fault/fault.hpp"

#include <algorithm>
#include <array>
#include <charconv>
#include <stdexcept>
#include <string>
#include <vector>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "base/nearest_name.hpp"
#include "tools/cli/csv.hpp"

namespace odomd::fault {
namespace {

using estimator::Source;

constexpr Sources gyro = only(Source::yaw_rate);
constexpr Sources accel_x = only(Source::accel_x);
constexpr Sources accel_y = only(Source::accel_y);
constexpr Sources front = only(Source::wheel_front_left) | only(Source::wheel_front_right);
constexpr Sources rear =
    only(Source::wheel_rear_left) | only(Source::wheel_rear_right) | only(Source::wheel_rear);
constexpr Sources wheels = front | rear | only(Source::motor);

constexpr std::array part_table{
#define ODOMD_PART(name, what, ...) PartInfo{Part::name, #name, what, __VA_ARGS__},
#include "tools/fault/kinds.inc"
};

constexpr std::array act_table{
#define ODOMD_ACT(name, what, ...) ActInfo{Act::name, #name, what, {__VA_ARGS__}},
#include "tools/fault/kinds.inc"
};

// The unit of a source, and the default size of its faults.
struct Quantity {
  std::string_view unit;
  std::string_view rate_unit;
  double stuck;
  double bias;
  double ramp;  // per second
};
constexpr Quantity turn_rate{"rad/s", "rad/s2", 0.5, 0.2, 0.05};
constexpr Quantity acceleration{"m/s2", "m/s3", 2.0, 3.0, 0.5};
constexpr Quantity speed{"m/s", "m/s2", 1.0, 0.5, 0.1};
constexpr Quantity angle{"rad", "rad/s", 0.2, 0.1, 0.02};

constexpr bool is_speed(Part part) {
  return part >= Part::wheel_front_left && part <= Part::wheels;
}

// Null for parts with several quantities.
constexpr const Quantity* quantity_of(Part part) {
  if (part == Part::gyro) return &turn_rate;
  if (part == Part::accel_x || part == Part::accel_y || part == Part::accel) return &acceleration;
  if (part == Part::steering) return &angle;
  return is_speed(part) ? &speed : nullptr;
}

constexpr bool can(Part part, Act act) {
  const bool frames = act >= Act::lost && act <= Act::bit_flips_repaired;
  switch (part) {
    case Part::camera:
      return act >= Act::frozen_noisy || act == Act::frozen || act == Act::noisy ||
             (act >= Act::lost && act <= Act::duplicated);
    case Part::bus:
      return act >= Act::lost && act <= Act::shifted;
    case Part::direction:
      return frames || act == Act::frozen || act == Act::zero || act == Act::inverted;
    default:
      break;
  }
  switch (act) {
    case Act::stuck:
    case Act::biased:
    case Act::ramped:
      return quantity_of(part) != nullptr;
    case Act::slipping:
    case Act::locked:
      return is_speed(part);
    case Act::left_right:
    case Act::front_rear:
      return part == Part::wheels;
    case Act::axes_swapped:
      return part == Part::accel;
    default:
      return act <= Act::rounded || frames;
  }
}

std::vector<std::string_view> split(std::string_view text) {
  std::vector<std::string_view> parts;
  for (std::size_t at = 0; at <= text.size();) {
    const std::size_t end = std::min(text.find(':', at), text.size());
    parts.push_back(text.substr(at, end - at));
    at = end + 1;
  }
  return parts;
}

// An empty part keeps the value.
void read(std::string_view whole, std::string_view part, std::string_view what, double& value) {
  if (part.empty()) return;
  double number = 0.0;
  const auto [end, error] = std::from_chars(part.data(), part.data() + part.size(), number);
  if (error != std::errc{} || end != part.data() + part.size() || !std::isfinite(number))
    throw std::invalid_argument(tools::quoted(whole) + ": the " + std::string(what) + " " +
                                tools::quoted(part) +
                                " is not a number; a fault is KIND:BEGIN:LENGTH:SIZE");
  value = number;
}

constexpr std::size_t width = 100;

std::vector<Kind> kinds_of(Part part) {
  std::vector<Kind> kinds;
  std::ranges::copy_if(all_kinds(), std::back_inserter(kinds),
                       [part](Kind kind) { return kind.part == part; });
  return kinds;
}

std::string size_text(Magnitude size) {
  if (size.unit == "x") return fmt::format("x {}", size.value);
  return fmt::format("{} {}", size.value, size.unit);
}

// "0.2 rad/s, 3 m/s2": the sizes for all parts, each once.
std::string sizes_of(Act act) {
  std::vector<std::string> sizes;
  for (const Kind kind : all_kinds()) {
    if (kind.act != act || default_magnitude(kind).unit.empty()) continue;
    const std::string size = size_text(default_magnitude(kind));
    if (std::ranges::find(sizes, size) == sizes.end()) sizes.push_back(size);
  }
  std::string text;
  for (const std::string& size : sizes) text += (text.empty() ? "" : ", ") + size;
  return text;
}

void append_ways(std::string& text, Part part) {
  constexpr std::string_view indent = "    ";
  std::string line(indent);
  for (const Kind kind : kinds_of(part)) {
    const std::string_view name = info(kind.act).name;
    if (line.size() + name.size() + 1 > width) {
      text += line + '\n';
      line = indent;
    }
    if (line.size() > indent.size()) line += ' ';
    line += name;
  }
  text += line + '\n';
}

}  // namespace

std::span<const PartInfo> parts() noexcept {
  return part_table;
}

std::span<const ActInfo> acts() noexcept {
  return act_table;
}

const PartInfo& info(Part part) noexcept {
  return part_table[static_cast<std::size_t>(part)];
}

const ActInfo& info(Act act) noexcept {
  return act_table[static_cast<std::size_t>(act)];
}

const std::vector<Kind>& all_kinds() {
  static const std::vector<Kind> kinds = [] {
    std::vector<Kind> all;
    for (const PartInfo& part : part_table)
      for (const ActInfo& act : act_table)
        if (can(part.part, act.act)) all.push_back({part.part, act.act});
    return all;
  }();
  return kinds;
}

std::string name_of(Kind kind) {
  return std::string(info(kind.part).name).append(1, '.').append(info(kind.act).name);
}

Kind parse_kind(std::string_view name) {
  std::vector<std::string> names;
  for (const Kind kind : all_kinds()) {
    names.push_back(name_of(kind));
    if (names.back() == name) return kind;
  }
  throw std::invalid_argument("there is no kind of fault \"" + std::string(name) + '"' +
                              nearest_hint(name, names) + "; odom fault --list shows all");
}

Magnitude default_magnitude(Kind kind) noexcept {
  const Quantity* const quantity = quantity_of(kind.part);
  if (kind.act == Act::stuck) return {quantity->stuck, quantity->unit};
  if (kind.act == Act::biased) return {quantity->bias, quantity->unit};
  if (kind.act == Act::ramped) return {quantity->ramp, quantity->rate_unit};
  return info(kind.act).magnitude;
}

Sources sources_of(Kind kind) noexcept {
  return info(kind.part).sources;
}

Fault fault_of(Kind kind) {
  return {.kind = kind, .magnitude = default_magnitude(kind).value};
}

void check(const Fault& fault) {
  const std::string name = name_of(fault.kind);
  const Magnitude usual = default_magnitude(fault.kind);
  if (!(fault.begin_s >= 0.0) || !std::isfinite(fault.begin_s))
    throw std::invalid_argument(name + ": begins before the first frame; give 0 s or more");
  if (!(fault.duration_s > 0.0))
    throw std::invalid_argument(name + ": has no duration; give more than 0 s");
  if (usual.unit.empty() && fault.magnitude != usual.value)
    throw std::invalid_argument(name + ": has no size; leave it out");
  if (usual.unit == "share" && !(fault.magnitude >= 0.0 && fault.magnitude <= 1.0))
    throw std::invalid_argument(name + ": its size is a share of the frames; give 0 to 1");
  if (usual.unit == "sigma" && !(fault.magnitude >= 0.0))
    throw std::invalid_argument(name + ": its size is a number of sigmas; give 0 or more");
  const bool may_lead = fault.kind.act == Act::shifted;
  if (usual.unit == "s" && !may_lead && !(fault.magnitude >= 0.0))
    throw std::invalid_argument(name + ": its size is a time; give 0 s or more");
}

Fault parse_fault(std::string_view text) {
  const std::vector<std::string_view> parts = split(text);
  if (parts.size() > 4)
    throw std::invalid_argument(tools::quoted(text) +
                                ": has more parts than KIND:BEGIN:LENGTH:SIZE");
  Fault fault = fault_of(parse_kind(parts[0]));
  if (parts.size() > 1) read(text, parts[1], "begin", fault.begin_s);
  if (parts.size() > 2) read(text, parts[2], "length", fault.duration_s);
  if (parts.size() > 3) read(text, parts[3], "size", fault.magnitude);
  check(fault);
  return fault;
}

std::string kinds_text() {
  std::string text =
      "A kind of fault is PART.WAY, such as gyro.frozen.\n\nParts and their ways to fail:\n";
  for (const PartInfo& part : parts()) {
    text += fmt::format("  {}: {}\n", part.name, part.what);
    append_ways(text, part.part);
  }
  text += "\nWays to fail, with the default size:\n";
  for (const ActInfo& act : acts()) {
    const std::string sizes = sizes_of(act.act);
    text +=
        fmt::format("  {:<19} {}{}\n", act.name, act.what, sizes.empty() ? "" : " (" + sizes + ")");
  }
  return text;
}

nlohmann::ordered_json kinds_json() {
  auto all = nlohmann::ordered_json::array();
  for (const Kind kind : all_kinds()) {
    const Magnitude size = default_magnitude(kind);
    auto sources = nlohmann::ordered_json::array();
    for (std::size_t i = 0; i < estimator::source_count; ++i)
      if (contains(sources_of(kind), static_cast<estimator::Source>(i)))
        sources.push_back(estimator::source_names[i]);
    nlohmann::ordered_json one{{"kind", name_of(kind)},
                               {"part", info(kind.part).what},
                               {"what", info(kind.act).what},
                               {"size", nullptr},
                               {"unit", nullptr},
                               {"sources", std::move(sources)}};
    if (!size.unit.empty()) {
      one["size"] = size.value;
      one["unit"] = size.unit;
    }
    all.push_back(std::move(one));
  }
  return all;
}

}  // namespace odomd::fault
