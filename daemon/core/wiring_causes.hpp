// Tables of what Wiring compares, and of the effect of each cause; and whether the observations of
// a pair of sensors fit what one or two causes predict.
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <iterator>

#include "daemon/core/comparison.hpp"
#include "daemon/core/wiring.hpp"
#include "estimator/common/measurement.hpp"

namespace odomd::daemon::wiring {

using estimator::index_of;
using estimator::Source;
using estimator::wheel_sources;

// The compared quantities, each over two consecutive pieces. Wheels give the turn as a curvature,
// because a difference of their radii then causes a constant offset only.
enum Quantity : std::uint8_t {
  turn_gyro,         // ψ̇ [rad/s]
  turn_steering,     // v δ / l
  turn_camera,       //
  curve_gyro,        // ψ̇ / v; this and the next three are times the track width [1]
  curve_steering,    // δ / l
  curve_front,       // (v_right - v_left) / v
  curve_rear,        //
  lateral_gyro,      // v ψ̇ [m/s²]
  lateral_steering,  // v² δ / l
  side,              // a_y
  ahead,             // a_x
  faster,            // dv/dt
  first_wheel,       // [m/s], in the order of wheel_sources
  last_wheel = first_wheel + wheel_sources.size() - 1,
  speed,         // median of the wheels' speeds
  speed_camera,  //
  axle_gap,      // how much faster the front wheels are than the rear ones [1]
  axle_bend,     // axle_gap in a turn without tyre slip, (l ψ̇ / v)² / 2
  quantity_count
};
constexpr Quantity quantity_of(Source wheel) {
  return static_cast<Quantity>(
      first_wheel +
      std::ranges::distance(wheel_sources.begin(), std::ranges::find(wheel_sources, wheel)));
}

// Whether a pair measures the same quantity or unrelated ones.
enum class Relation : std::uint8_t { same, none };
struct Pair {
  Quantity a, b;
  Comparison::Bounds bounds;
  double about;  ///< gain up to which the two units are the same
  double other;  ///< gain from which the units differ; between `about` and `other` it may be slip
  Relation relation = Relation::same;
};
inline constexpr double any = 1e12;
inline constexpr Comparison::Bounds turns{0.05, 0.05, 0.08}, curves{0.02, 0.02, 0.01},
    sideways{1.0, 0.3, 0.6}, lengthways{1.0, 0.0, 0.4}, ways{0.0, 0.0, 0.1}, axles{0.1, 0.1, 0.008};
inline constexpr Pair pairs_without_wheels[] = {
    {turn_gyro, turn_steering, turns, 2.0, 25.0},
    {turn_gyro, turn_camera, turns, 2.0, 10.0},
    {turn_steering, turn_camera, turns, 2.0, 25.0},
    {curve_gyro, curve_front, curves, 1.5, 25.0},
    {curve_gyro, curve_rear, curves, 1.5, 25.0},
    {curve_steering, curve_front, curves, 1.5, 25.0},
    {curve_steering, curve_rear, curves, 1.5, 25.0},
    {curve_front, curve_rear, curves, 1.5, any},
    {side, lateral_gyro, sideways, 2.0, 3.0},
    {side, lateral_steering, sideways, 2.0, 25.0},
    {ahead, faster, lengthways, 2.0, 3.0},
    {ahead, lateral_gyro, sideways, 2.0, any, Relation::none},
    {side, faster, lengthways, 2.0, any, Relation::none},
    {speed_camera, speed, ways, 2.0, 3.0},
    {axle_gap, axle_bend, axles, 1.5, any},
};
inline constexpr auto pairs = [] {
  std::array<Pair, Wiring::pair_count> all{};
  auto* next = std::ranges::copy(pairs_without_wheels, all.begin()).out;
  for (const Source wheel : wheel_sources) *next++ = {quantity_of(wheel), speed, ways, 1.5, 1.7};
  return all;
}();
static_assert(std::size(pairs_without_wheels) + wheel_sources.size() == pairs.size());

// The effect of a cause on a quantity: a factor from `least` to `most` with a sign. Sign 0: not
// predictable.
struct Factor {
  double least = 1.0, most = 1.0;
  int sign = 1;
  bool other = false;  ///< the inverse factor is possible, too
};
constexpr Factor operator*(const Factor& a, const Factor& b) {
  return {a.least * b.least, a.most * b.most, a.sign * b.sign, a.other || b.other};
}
inline constexpr Factor reversed{1.0, 1.0, -1}, lost{1.0, 1.0, 0};
inline constexpr Factor degrees{25.0, 110.0}, radians{1.0 / 110.0, 1.0 / 25.0};
inline constexpr Factor cut_degrees{10.0, 110.0};  // clipped at the range of the bus or the gyro
inline constexpr Factor km_per_h{3.0, 4.3}, in_g{0.06, 0.16}, millimetres{30.0, 3000.0};
inline constexpr Factor geared{1.7, 1e3, 1, true};  // a ratio, a diameter instead of a radius, 2 pi

constexpr std::uint32_t bits(auto... of) {
  return ((1U << static_cast<unsigned>(of)) | ...);
}
struct Effect {
  std::uint32_t quantities = 0;  ///< bits
  Factor factor;
};
struct Cause {
  WiringFault fault = WiringFault::none;
  int cost = 0;  ///< larger for rarer causes
  std::uint32_t sources = 0;
  std::array<Effect, 3> effects{};
};

using enum Source;
using WiringFault::axes_swapped, WiringFault::front_rear_swapped, WiringFault::left_right_swapped,
    WiringFault::sign, WiringFault::unit;
inline constexpr std::uint32_t front_wheels = bits(wheel_front_left, wheel_front_right);
inline constexpr std::uint32_t rear_wheels = bits(wheel_rear_left, wheel_rear_right);
inline constexpr std::uint32_t all_wheels = estimator::wheels;
inline constexpr std::uint32_t by_gyro = bits(turn_gyro, curve_gyro, lateral_gyro);
inline constexpr std::uint32_t by_steering = bits(turn_steering, curve_steering, lateral_steering);
inline constexpr std::uint32_t by_slip = bits(curve_front, curve_rear, axle_gap);
inline constexpr std::uint32_t by_speed =
    (bits(quantity_count) - 1U) & ~bits(turn_gyro, turn_camera, side, ahead);
inline constexpr std::uint32_t speeds = (bits(speed) << 1U) - bits(first_wheel);

constexpr Cause one_wheel(WiringFault fault, Source wheel) {
  const std::uint32_t shown_in = !is_single_wheel(wheel) ? 0
                                 : is_front(wheel)       ? bits(curve_front, axle_gap)
                                                         : bits(curve_rear, axle_gap);
  return {fault,
          2,
          bits(wheel),
          {{{bits(quantity_of(wheel)), fault == sign ? reversed : geared}, {shown_in, lost}}}};
}
constexpr Cause one_side(Source front, Source rear) {
  return {sign,
          3,
          bits(front, rear),
          {{{bits(quantity_of(front), quantity_of(rear)), reversed},
            {bits(curve_front, curve_rear, axle_gap), lost}}}};
}
inline constexpr Cause causes_of_several[] = {
    {sign, 2, bits(yaw_rate), {{{by_gyro, reversed}}}},
    {unit, 2, bits(yaw_rate), {{{by_gyro, cut_degrees}, {bits(axle_bend), lost}}}},
    {unit, 2, bits(yaw_rate), {{{by_gyro, radians}, {bits(axle_bend), lost}}}},
    {sign, 2, bits(steering), {{{by_steering, reversed}}}},
    {unit, 2, bits(steering), {{{by_steering, degrees}}}},
    {unit, 2, bits(steering), {{{by_steering, radians}}}},
    {left_right_swapped, 2, front_wheels, {{{bits(curve_front), reversed}}}},
    {left_right_swapped, 2, rear_wheels, {{{bits(curve_rear), reversed}}}},
    {left_right_swapped,
     3,
     front_wheels | rear_wheels,
     {{{bits(curve_front, curve_rear), reversed}}}},
    {front_rear_swapped, 2, front_wheels | rear_wheels, {{{bits(axle_gap), reversed}}}},
    {sign,
     3,
     all_wheels | bits(direction),
     {{{bits(turn_steering, curve_gyro, lateral_gyro, faster), reversed}}}},
    {unit,
     3,
     all_wheels,
     {{{bits(turn_steering, lateral_gyro, faster) | speeds, km_per_h},
       {bits(lateral_steering), km_per_h* km_per_h},
       {bits(axle_bend), lost}}}},
    {sign, 2, bits(accel_x), {{{bits(ahead), reversed}}}},
    {sign, 2, bits(accel_y), {{{bits(side), reversed}}}},
    {axes_swapped, 2, bits(accel_x, accel_y), {}},
    {unit, 2, bits(accel_x, accel_y), {{{bits(ahead, side), in_g}}}},
    {unit, 2, bits(accel_x), {{{bits(ahead), in_g}}}},
    {unit, 2, bits(accel_y), {{{bits(side), in_g}}}},
    {sign, 2, bits(camera), {{{bits(turn_camera), reversed}}}},
    {unit, 2, bits(camera), {{{bits(speed_camera), millimetres}}}},
};
inline constexpr auto causes = [] {
  std::array<Cause, Wiring::cause_count> all{};
  auto* next = std::ranges::copy(causes_of_several, all.begin()).out;
  for (const WiringFault fault : {sign, unit})
    for (const Source wheel : wheel_sources) *next++ = one_wheel(fault, wheel);
  *next++ = one_side(wheel_front_left, wheel_rear_left);
  *next++ = one_side(wheel_front_right, wheel_rear_right);
  return all;
}();
static_assert(std::size(causes_of_several) + 2 * wheel_sources.size() + 2 == causes.size());
inline constexpr std::uint8_t nothing = Wiring::cause_count;  ///< no cause

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

inline constexpr double alike = 0.7;       // below this correlation a gain means nothing
inline constexpr double very_alike = 0.8;  // above this correlation quantities are related

// The same fault cannot occur twice on one source, and two wrong units would explain too much.
inline bool exclude(std::uint8_t one, std::uint8_t other) noexcept {
  return other != nothing && causes[one].fault == causes[other].fault &&
         (causes[one].fault == WiringFault::unit ||
          (causes[one].sources & causes[other].sources) != 0);
}

inline bool swaps_axes(std::uint8_t cause) noexcept {
  return cause != nothing && causes[cause].fault == WiringFault::axes_swapped;
}

// The observations of a pair.
struct Seen {
  bool shows = false;
  double correlation = 0.0, gain = 0.0;
};
enum class Fit : std::uint8_t { open, fits, contradicts };

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
  const double off = std::max(seen.gain, 1.0 / seen.gain);
  const bool same_unit = a.least == b.least && a.most == b.most;
  const bool predicted = same_unit ? off <= pair.about
                         : a.other ? off >= a.least && off <= a.most
                                   : seen.gain >= a.least / b.most && seen.gain <= a.most / b.least;
  if (predicted && (seen.correlation > 0.0) == (a.sign * b.sign > 0)) return Fit::fits;
  // No unit explains this gain, but tyre slip, wheel spin or understeer may.
  return off > pair.about && off < pair.other ? Fit::open : Fit::contradicts;
}

}  // namespace odomd::daemon::wiring
