#include "tools/fault/fault.hpp"

#include <algorithm>
#include <array>
#include <ranges>
#include <stdexcept>
#include <string>
#include <vector>

#include <fmt/format.h>
#include <fmt/ranges.h>
#include <nlohmann/json.hpp>

#include "base/nearest_name.hpp"
#include "tools/cli/csv.hpp"

namespace odomd::fault {
namespace {

using estimator::Source;

constexpr Sources gyro = only(Source::yaw_rate);
constexpr Sources accel_x = only(Source::accel_x);
constexpr Sources accel_y = only(Source::accel_y);
constexpr Sources wheels = estimator::wheels;
constexpr Sources front = estimator::set_of(estimator::is_front);
constexpr Sources rear = wheels & ~front & ~only(Source::motor);

constexpr FaultSizes turn_rate{"rad/s", "rad/s2", 0.5, 0.2, 0.05};
constexpr FaultSizes acceleration{"m/s2", "m/s3", 2.0, 3.0, 0.5};
constexpr FaultSizes speed{"m/s", "m/s2", 1.0, 0.5, 0.1};
constexpr FaultSizes angle{"rad", "rad/s", 0.2, 0.1, 0.02};

constexpr Groups sensors = 1, directions = 2, buses = 4, cameras = 8;
constexpr Groups quantities = 16, speeds = 32, exchangeable_speeds = 64, exchangeable_axes = 128;
constexpr Groups signals = sensors | directions, frames = signals | buses;
constexpr Groups everything = frames | cameras;
constexpr Groups a_quantity = sensors | quantities, a_speed = a_quantity | speeds;
constexpr Groups all_speeds = a_speed | exchangeable_speeds;
constexpr Groups both_axes = a_quantity | exchangeable_axes;

constexpr std::array part_table{
#define ODOMD_PART(name, what, ...) PartInfo{Part::name, #name, what, __VA_ARGS__},
#include "tools/fault/kinds.inc"
};

constexpr std::array act_table{
#define ODOMD_ACT(name, what, groups, ...) ActInfo{Act::name, #name, what, groups, {__VA_ARGS__}},
#include "tools/fault/kinds.inc"
};

std::invalid_argument wrong(std::string_view fault, std::string_view what) {
  return std::invalid_argument(fmt::format("{}: {}", fault, what));
}

std::string size_text(Magnitude size) {
  return size.unit == "x" ? fmt::format("x {}", size.value)
                          : fmt::format("{} {}", size.value, size.unit);
}

// "0.2 rad/s, 3 m/s2": the default size for every part, without repeats.
std::string sizes_of(Act act) {
  std::vector<std::string> sizes;
  for (const FaultKind kind : all_kinds()) {
    if (kind.act != act || default_magnitude(kind).unit.empty()) continue;
    const std::string size = size_text(default_magnitude(kind));
    if (std::ranges::find(sizes, size) == sizes.end()) sizes.push_back(size);
  }
  return fmt::format("{}", fmt::join(sizes, ", "));
}

// The part's ways to fail, in lines of this width.
std::string ways_of(Part part) {
  constexpr std::size_t width = 100;
  std::string text, line = "   ";
  for (const FaultKind kind : all_kinds()) {
    if (kind.part != part) continue;
    const std::string_view name = info(kind.act).name;
    if (line.size() + 1 + name.size() > width) {
      text += line + '\n';
      line = "   ";
    }
    line.append(1, ' ').append(name);
  }
  return text + line + '\n';
}

}  // namespace

std::vector<std::string_view> names_of(Sources sources) {
  std::vector<std::string_view> names;
  for (const Source source : estimator::all_sources)
    if (contains(sources, source)) names.push_back(info_of(source).name);
  return names;
}

const PartInfo& info(Part part) noexcept {
  return part_table[static_cast<std::size_t>(part)];
}

const ActInfo& info(Act act) noexcept {
  return act_table[static_cast<std::size_t>(act)];
}

const std::vector<FaultKind>& all_kinds() {
  static const std::vector<FaultKind> kinds = [] {
    std::vector<FaultKind> all;
    for (const PartInfo& part : part_table)
      for (const ActInfo& act : act_table)
        if ((part.groups & act.groups) != 0) all.push_back({part.part, act.act});
    return all;
  }();
  return kinds;
}

std::string name_of(FaultKind kind) {
  return std::string(info(kind.part).name).append(1, '.').append(info(kind.act).name);
}

FaultKind parse_kind(std::string_view name) {
  std::vector<std::string> names;
  for (const FaultKind kind : all_kinds()) {
    names.push_back(name_of(kind));
    if (names.back() == name) return kind;
  }
  throw std::invalid_argument("there is no kind of fault \"" + std::string(name) + '"' +
                              nearest_hint(name, names) + "; odom fault --list shows all");
}

Magnitude default_magnitude(FaultKind kind) noexcept {
  const FaultSizes& quantity = info(kind.part).quantity;
  if (kind.act == Act::stuck) return {quantity.stuck, quantity.unit};
  if (kind.act == Act::biased) return {quantity.bias, quantity.unit};
  if (kind.act == Act::ramped) return {quantity.ramp, quantity.rate_unit};
  return info(kind.act).magnitude;
}

Sources sources_of(FaultKind kind) noexcept {
  return info(kind.part).sources;
}

Fault fault_of(FaultKind kind) {
  return {.kind = kind, .magnitude = default_magnitude(kind).value};
}

void check(const Fault& fault) {
  const std::string name = name_of(fault.kind);
  const Magnitude usual = default_magnitude(fault.kind);
  if (!(fault.begin_s >= 0.0) || !std::isfinite(fault.begin_s))
    throw wrong(name, "begins before the first frame; give 0 s or more");
  if (!(fault.duration_s > 0.0)) throw wrong(name, "has no duration; give more than 0 s");
  if (usual.unit.empty() && fault.magnitude != usual.value)
    throw wrong(name, "has no size; leave it out");
  if (usual.unit == "share" && !(fault.magnitude >= 0.0 && fault.magnitude <= 1.0))
    throw wrong(name, "its size is a share of the frames; give 0 to 1");
  if (fault.kind.act == Act::shifted || fault.magnitude >= 0.0) return;
  if (usual.unit == "sigma") throw wrong(name, "its size is a number of sigmas; give 0 or more");
  if (usual.unit == "s") throw wrong(name, "its size is a time; give 0 s or more");
}

Fault parse_fault(std::string_view text) {
  std::vector<std::string> parts;
  for (const auto part : std::views::split(text, ':')) parts.emplace_back(part.begin(), part.end());
  if (parts.size() > 4)
    throw wrong(tools::quoted(text), "has more parts than KIND:BEGIN:LENGTH:SIZE");
  Fault fault = fault_of(parse_kind(parts.empty() ? "" : parts[0]));
  constexpr std::array names{"begin", "length", "size"};
  const std::array values{&fault.begin_s, &fault.duration_s, &fault.magnitude};
  for (std::size_t i = 1; i < parts.size(); ++i) {
    if (parts[i].empty()) continue;  // keeps the default
    const auto number = tools::parse_number(parts[i]);
    if (!number || !std::isfinite(*number))
      throw wrong(tools::quoted(text),
                  fmt::format("the {} {} is not a number; a fault is KIND:BEGIN:LENGTH:SIZE",
                              names[i - 1], tools::quoted(parts[i])));
    *values[i - 1] = *number;
  }
  check(fault);
  return fault;
}

std::string kinds_text() {
  std::string text =
      "A kind of fault is PART.WAY, such as gyro.frozen.\n\nParts and their ways to fail:\n";
  for (const PartInfo& part : part_table) {
    text += fmt::format("  {}: {}\n{}", part.name, part.what, ways_of(part.part));
  }
  text += "\nWays to fail, with the default size:\n";
  for (const ActInfo& act : act_table) {
    const std::string sizes = sizes_of(act.act);
    text +=
        fmt::format("  {:<19} {}{}\n", act.name, act.what, sizes.empty() ? "" : " (" + sizes + ")");
  }
  return text;
}

nlohmann::ordered_json kinds_json() {
  auto all = nlohmann::ordered_json::array();
  for (const FaultKind kind : all_kinds()) {
    const Magnitude size = default_magnitude(kind);
    nlohmann::ordered_json one{{"kind", name_of(kind)},
                               {"part", info(kind.part).what},
                               {"what", info(kind.act).what},
                               {"size", nullptr},
                               {"unit", nullptr},
                               {"sources", names_of(sources_of(kind))}};
    if (!size.unit.empty()) {
      one["size"] = size.value;
      one["unit"] = size.unit;
    }
    all.push_back(std::move(one));
  }
  return all;
}

}  // namespace odomd::fault
