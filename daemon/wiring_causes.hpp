// What Wiring compares, and what each mistake makes of it: tables, and whether a pair is what a
// mistake foretells.
#pragma once

#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <iterator>

#include "daemon/comparison.hpp"
#include "daemon/wiring.hpp"
#include "estimator/common/measurement.hpp"

namespace odomd::daemon::wiring {

using estimator::index_of;
using estimator::Source;

inline constexpr double alike = 0.7;       // correlation
inline constexpr double very_alike = 0.8;  // of what has nothing to do with each other

// What is compared, of every piece with that before. A turn by wheels is a curve, which a
// difference of their radii offsets and no more.
enum Quantity : std::uint8_t {
  turn_gyro,         // ψ̇ [rad/s]
  turn_steering,     // v δ / l
  turn_camera,       //
  curve_gyro,        // ψ̇ / v, over the track [1], as the next three
  curve_steering,    // δ / l
  curve_front,       // (v_right - v_left) / v
  curve_rear,        //
  lateral_gyro,      // v ψ̇ [m/s²]
  lateral_steering,  // v² δ / l
  side,              // a_y
  ahead,             // a_x
  faster,            // dv/dt
  first_wheel,       // [m/s], in the order of Source
  last_wheel = first_wheel + 5,
  speed,         // their median
  speed_camera,  //
  axle_gap,      // how much faster the front wheels go than the rear ones [1]
  axle_bend,     // ... as they must by the turn, (l ψ̇ / v)² / 2, while the tyres hardly slip
  quantity_count
};
constexpr Quantity quantity_of(Source wheel) {
  return static_cast<Quantity>(first_wheel + index_of(wheel) - index_of(Source::wheel_front_left));
}

// Whether the two are one quantity, or have nothing to do with each other.
enum class Relation : std::uint8_t { same, none };
struct Pair {
  Quantity a, b;
  Comparison::Bounds bounds;
  double about = 3.0;  ///< so many times more or less may be slip
  Relation relation = Relation::same;
};
inline constexpr double any = 1e9;
inline constexpr Comparison::Bounds turns{0.05, 0.05, 0.08}, curves{0.02, 0.02, 0.01},
    sideways{1.0, 0.3, 0.6}, lengthways{1.0, 0.0, 0.4}, ways{0.0, 0.0, 0.1}, axles{0.1, 0.1, 0.008};
inline constexpr std::array<Pair, Wiring::pair_count> pairs{{
    {turn_gyro, turn_steering, turns, 4.0},
    {turn_gyro, turn_camera, turns},
    {turn_steering, turn_camera, turns, 4.0},
    {curve_gyro, curve_front, curves, any},
    {curve_gyro, curve_rear, curves, any},
    {curve_steering, curve_front, curves, any},
    {curve_steering, curve_rear, curves, any},
    {curve_front, curve_rear, curves, any},
    {side, lateral_gyro, sideways},
    {side, lateral_steering, sideways},
    {ahead, faster, lengthways},
    {ahead, lateral_gyro, sideways, 2.0, Relation::none},
    {side, faster, lengthways, 2.0, Relation::none},
    {quantity_of(Source::wheel_front_left), speed, ways},
    {quantity_of(Source::wheel_front_right), speed, ways},
    {quantity_of(Source::wheel_rear_left), speed, ways},
    {quantity_of(Source::wheel_rear_right), speed, ways},
    {quantity_of(Source::wheel_rear), speed, ways},
    {quantity_of(Source::motor), speed, ways},
    {speed_camera, speed, ways},
    {axle_gap, axle_bend, axles},
}};

// What a mistake makes of a quantity: from `least` to `most` times as much, with a sign; 0: nothing
// that can be foretold.
struct Factor {
  double least = 1.0, most = 1.0;
  int sign = 1;
};
constexpr Factor operator*(const Factor& a, const Factor& b) {
  return {a.least * b.least, a.most * b.most, a.sign * b.sign};
}
inline constexpr Factor reversed{1.0, 1.0, -1}, lost{1.0, 1.0, 0};
inline constexpr Factor degrees{10.0, 110.0}, radians{1.0 / 110.0, 1.0 / 10.0};
inline constexpr Factor km_per_h{3.0, 4.3}, in_g{0.06, 0.16}, millimetres{30.0, 3000.0};

constexpr std::uint32_t bits(auto... of) {
  return ((1U << static_cast<unsigned>(of)) | ...);
}
struct Effect {
  std::uint32_t quantities = 0;  ///< bits
  Factor factor;
};
struct Cause {
  WiringFault fault = WiringFault::none;
  int cost = 0;  ///< the larger, the more seldom
  std::uint32_t sources = 0;
  std::array<Effect, 3> effects{};
};

using enum Source;
inline constexpr std::uint32_t front_wheels = bits(wheel_front_left, wheel_front_right);
inline constexpr std::uint32_t rear_wheels = bits(wheel_rear_left, wheel_rear_right);
inline constexpr std::uint32_t all_wheels = front_wheels | rear_wheels | bits(wheel_rear, motor);
inline constexpr std::uint32_t by_gyro = bits(turn_gyro, curve_gyro, lateral_gyro);
inline constexpr std::uint32_t by_steering = bits(turn_steering, curve_steering, lateral_steering);
inline constexpr std::uint32_t speeds = (bits(speed) << 1U) - bits(first_wheel);

constexpr Cause one_wheel(Source wheel, Quantity curve) {
  return {WiringFault::sign,
          2,
          bits(wheel),
          {{{bits(quantity_of(wheel)), reversed}, {bits(curve, axle_gap), lost}}}};
}
inline constexpr Cause causes[] = {
    {WiringFault::sign, 2, bits(yaw_rate), {{{by_gyro, reversed}}}},
    {WiringFault::unit, 2, bits(yaw_rate), {{{by_gyro, degrees}, {bits(axle_bend), lost}}}},
    {WiringFault::unit, 2, bits(yaw_rate), {{{by_gyro, radians}, {bits(axle_bend), lost}}}},
    {WiringFault::sign, 2, bits(steering), {{{by_steering, reversed}}}},
    {WiringFault::unit, 2, bits(steering), {{{by_steering, degrees}}}},
    {WiringFault::unit, 2, bits(steering), {{{by_steering, radians}}}},
    {WiringFault::left_right_swapped, 2, front_wheels, {{{bits(curve_front), reversed}}}},
    {WiringFault::left_right_swapped, 2, rear_wheels, {{{bits(curve_rear), reversed}}}},
    {WiringFault::left_right_swapped,
     3,
     front_wheels | rear_wheels,
     {{{bits(curve_front, curve_rear), reversed}}}},
    {WiringFault::front_rear_swapped,
     2,
     front_wheels | rear_wheels,
     {{{bits(axle_gap), reversed}}}},
    {WiringFault::sign,
     3,
     all_wheels,
     {{{bits(turn_steering, curve_gyro, lateral_gyro, faster), reversed}}}},
    {WiringFault::unit,
     3,
     all_wheels,
     {{{bits(turn_steering, lateral_gyro, faster) | speeds, km_per_h},
       {bits(lateral_steering), km_per_h* km_per_h},
       {bits(axle_bend), lost}}}},
    {WiringFault::sign, 2, bits(accel_x), {{{bits(ahead), reversed}}}},
    {WiringFault::sign, 2, bits(accel_y), {{{bits(side), reversed}}}},
    {WiringFault::axes_swapped, 2, bits(accel_x, accel_y), {}},
    {WiringFault::unit, 2, bits(accel_x, accel_y), {{{bits(ahead, side), in_g}}}},
    {WiringFault::sign, 2, bits(camera), {{{bits(turn_camera), reversed}}}},
    {WiringFault::unit, 2, bits(camera), {{{bits(speed_camera), millimetres}}}},
    one_wheel(wheel_front_left, curve_front),
    one_wheel(wheel_front_right, curve_front),
    one_wheel(wheel_rear_left, curve_rear),
    one_wheel(wheel_rear_right, curve_rear),
    one_wheel(wheel_rear, curve_rear),
    one_wheel(motor, curve_rear),
};
inline constexpr std::uint8_t nothing = Wiring::cause_count;  ///< is wrong
static_assert(std::size(causes) == nothing);

using Factors = std::array<Factor, quantity_count>;
inline constexpr std::array<Factors, nothing + 1> factors = [] {
  std::array<Factors, nothing + 1> table{};
  for (Factors& row : table) row.fill(Factor{});
  for (std::size_t cause = 0; cause < nothing; ++cause)
    for (const Effect& effect : causes[cause].effects)
      for (std::size_t q = 0; q < quantity_count; ++q)
        if ((effect.quantities >> q & 1U) != 0) table[cause][q] = effect.factor;
  return table;
}();

// One thing cannot be wrong in the same way twice, and two units would explain too much.
inline bool exclude(std::uint8_t one, std::uint8_t other) {
  return other != nothing && causes[one].fault == causes[other].fault &&
         (causes[one].fault == WiringFault::unit ||
          (causes[one].sources & causes[other].sources) != 0);
}

inline bool swaps_axes(std::uint8_t cause) {
  return cause != nothing && causes[cause].fault == WiringFault::axes_swapped;
}

// What is seen of a pair.
struct Seen {
  bool shows = false;
  double correlation = 0.0, gain = 0.0;
};
enum class Fit : std::uint8_t { open, fits, contradicts };

// Whether a pair is what one or two causes make of it.
inline Fit fit(const std::array<std::uint8_t, 2>& by, const Pair& pair, const Seen& seen) noexcept {
  if (!seen.shows) return Fit::open;
  const bool swapped = swaps_axes(by[0]) || swaps_axes(by[1]);
  if (pair.relation == Relation::none || (swapped && (pair.a == ahead || pair.a == side))) {
    const bool related = std::abs(seen.correlation) > very_alike && seen.gain > 1.0 / pair.about;
    if (swapped && pair.relation == Relation::none) return related ? Fit::fits : Fit::open;
    return related ? Fit::contradicts : Fit::open;
  }
  if (std::abs(seen.correlation) < alike) return Fit::open;
  const auto factor = [&](Quantity q) { return factors[by[0]][q] * factors[by[1]][q]; };
  const Factor a = factor(pair.a), b = factor(pair.b);
  if (a.sign * b.sign == 0) return Fit::open;
  const bool same_unit = a.least == b.least && a.most == b.most;
  const double least = same_unit ? 1.0 / pair.about : a.least / b.most;
  const double most = same_unit ? pair.about : a.most / b.least;
  return (seen.correlation > 0.0) == (a.sign * b.sign > 0) && seen.gain >= least &&
                 seen.gain <= most
             ? Fit::fits
             : Fit::contradicts;
}

}  // namespace odomd::daemon::wiring
