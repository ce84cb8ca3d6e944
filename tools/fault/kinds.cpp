#include "tools/fault/kinds.hpp"

#include <array>
#include <stdexcept>

#include "base/nearest_name.hpp"

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
  double ramp;  // a second
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

}  // namespace odomd::fault
