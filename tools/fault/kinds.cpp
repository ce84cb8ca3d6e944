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
    PartInfo{Part::gyro, "gyro", gyro, "the yaw rate"},
    PartInfo{Part::accel_x, "accel_x", accel_x, "the longitudinal acceleration"},
    PartInfo{Part::accel_y, "accel_y", accel_y, "the lateral acceleration"},
    PartInfo{Part::accel, "accel", accel_x | accel_y, "both accelerations"},
    PartInfo{Part::imu, "imu", gyro | accel_x | accel_y, "yaw rate and accelerations"},
    PartInfo{Part::steering, "steering", only(Source::steering), "the steering angle"},
    PartInfo{Part::wheel_front_left, "wheel_front_left", only(Source::wheel_front_left),
             "one wheel's speed"},
    PartInfo{Part::wheel_front_right, "wheel_front_right", only(Source::wheel_front_right),
             "one wheel's speed"},
    PartInfo{Part::wheel_rear_left, "wheel_rear_left", only(Source::wheel_rear_left),
             "one wheel's speed"},
    PartInfo{Part::wheel_rear_right, "wheel_rear_right", only(Source::wheel_rear_right),
             "one wheel's speed"},
    PartInfo{Part::wheel_rear, "wheel_rear", only(Source::wheel_rear), "the rear axle's speed"},
    PartInfo{Part::motor, "motor", only(Source::motor), "the motor's speed"},
    PartInfo{Part::front_wheels, "front_wheels", front, "the speeds of the front wheels"},
    PartInfo{Part::rear_wheels, "rear_wheels", rear, "the speeds of the rear wheels"},
    PartInfo{Part::wheels, "wheels", wheels, "all speeds: wheels, rear axle, motor"},
    PartInfo{Part::direction, "direction", only(Source::direction), "forward or reverse"},
    PartInfo{Part::bus, "bus", 0, "every frame, mapped or not"},
    PartInfo{Part::camera, "camera", only(Source::camera), "the camera's poses"},
};

constexpr std::array act_table{
    ActInfo{Act::frozen, "frozen", "repeats its last value", {}},
    ActInfo{Act::zero, "zero", "reads 0", {}},
    ActInfo{Act::stuck, "stuck", "reads one value", {}},
    ActInfo{Act::halved, "halved", "reads half the true value", {0.5, "x"}},
    ActInfo{Act::doubled, "doubled", "reads twice the true value", {2.0, "x"}},
    ActInfo{Act::scaled, "scaled", "reads a multiple of the true value", {1.3, "x"}},
    ActInfo{Act::biased, "biased", "has a constant bias", {}},
    ActInfo{Act::ramped, "ramped", "has a bias that grows at this rate per second", {}},
    ActInfo{Act::inverted, "inverted", "has the wrong sign", {}},
    ActInfo{Act::noisy, "noisy", "has noise of this many of its stated sigmas", {6.0, "sigma"}},
    ActInfo{Act::one_sided, "one_sided", "reads a multiple of the true value below 0", {0.7, "x"}},
    ActInfo{Act::rounded,
            "rounded",
            "is rounded to multiples of this many of its stated sigmas",
            {20.0, "sigma"}},
    ActInfo{Act::slipping,
            "slipping",
            "spins up to a multiple of its speed within half a second",
            {1.5, "x"}},
    ActInfo{Act::locked, "locked", "comes to a halt within half a second", {}},
    ActInfo{Act::left_right, "left_right", "left and right are exchanged", {}},
    ActInfo{Act::front_rear, "front_rear", "front and rear are exchanged", {}},
    ActInfo{Act::axes_swapped, "axes_swapped", "x and y are exchanged", {}},
    ActInfo{Act::lost, "lost", "is no longer sent", {}},
    ActInfo{Act::delayed, "delayed", "comes later by this time, with a late stamp", {0.1, "s"}},
    ActInfo{Act::duplicated, "duplicated", "comes twice, with counters of its own", {}},
    ActInfo{Act::reordered, "reordered", "comes in swapped pairs", {}},
    ActInfo{Act::jittered,
            "jittered",
            "has stamps up to this time too early or too late",
            {0.003, "s"}},
    ActInfo{Act::shifted,
            "shifted",
            "has stamps too late by this time; below 0: too early",
            {-0.05, "s"}},
    ActInfo{Act::bit_flips,
            "bit_flips",
            "has one bit wrong in this share of its frames",
            {0.1, "share"}},
    ActInfo{Act::bit_flips_repaired,
            "bit_flips_repaired",
            "likewise, with a valid CRC",
            {0.1, "share"}},
    ActInfo{Act::frozen_noisy,
            "frozen_noisy",
            "repeats its last pose with fresh noise",
            {1.0, "sigma"}},
    ActInfo{Act::moved, "moved", "is offset along the map's x", {0.5, "m"}},
    ActInfo{Act::turned, "turned", "is offset in yaw", {0.3, "rad"}},
    ActInfo{Act::drifting, "drifting", "drifts along the map's x at this speed", {0.1, "m/s"}},
    ActInfo{Act::mirrored, "mirrored", "has the wrong sign of y and yaw", {}},
    ActInfo{Act::outliers,
            "outliers",
            "is off by this distance in every fifth pose, in any direction",
            {1.0, "m"}},
    ActInfo{Act::early, "early", "has capture stamps too early by this time", {0.05, "s"}},
    ActInfo{Act::late, "late", "has capture stamps too late by this time", {0.05, "s"}},
    ActInfo{Act::skewed,
            "skewed",
            "has capture stamps of a clock that loses this time per second",
            {0.005, "s/s"}},
    ActInfo{Act::mixed, "mixed", "shows its pictures in swapped pairs, with stamps in order", {}},
    ActInfo{Act::vague, "vague", "states sigmas larger by this factor", {20.0, "x"}},
};

constexpr bool is_first_to_last(const auto& table, auto member) {
  for (std::size_t i = 0; i < table.size(); ++i)
    if (static_cast<std::size_t>(table[i].*member) != i) return false;
  return true;
}
static_assert(is_first_to_last(part_table, &PartInfo::part));
static_assert(is_first_to_last(act_table, &ActInfo::act));

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
