// The table of the sources: one row per sensor, with all its constants. Other lists, sets and
// tables of sources are derived from this table.
#pragma once

#include <algorithm>
#include <array>
#include <bit>
#include <cstddef>
#include <cstdint>
#include <string_view>
#include <utility>

namespace odomd::estimator {

/// The origin of a measurement. The numbers are part of the shared memory's layout (ages and health
/// bits are indexed by them): append only.
enum class Source : std::uint8_t {
  yaw_rate,
  accel_x,
  accel_y,
  wheel_front_left,
  wheel_front_right,
  wheel_rear_left,
  wheel_rear_right,
  wheel_rear,
  motor,
  steering,
  direction,
  camera,
  count
};
inline constexpr std::size_t source_count = static_cast<std::size_t>(Source::count);

enum class Quantity : std::uint8_t {
  yaw_rate,      ///< ψ̇ [rad/s]
  acceleration,  ///< specific force at the IMU [m/s²]
  speed,         ///< ground speed of a wheel or of the middle of an axle, signed [m/s]
  angle,         ///< δ at the front wheels [rad], left positive
  direction,     ///< +1 forward, -1 reverse, 0 unknown: the sign of unsigned wheel speeds
  pose           ///< in the map frame
};
enum class Axle : std::uint8_t { none, front, rear, driven };
enum class Side : std::int8_t { right = -1, middle = 0, left = 1 };

struct SourceInfo {
  std::string_view name;     ///< in configurations and outputs
  std::string_view meaning;  ///< for people
  Quantity quantity;
  double sigma;            ///< default standard deviation [unit of the quantity]
  double limit;            ///< largest magnitude for a car of any size [unit of the quantity]
  Axle axle = Axle::none;  ///< where a speed is measured
  Side side = Side::middle;
};

/// In the order of Source.
inline constexpr auto source_table = [] {
  using enum Quantity;
  using enum Axle;
  using enum Side;
  return std::to_array<SourceInfo>({
      {"yaw_rate", "yaw rate", yaw_rate, 0.03, 35.0},
      {"accel_x", "acceleration along the car", acceleration, 0.3, 200.0},
      {"accel_y", "acceleration across the car", acceleration, 0.3, 200.0},
      {"wheel_front_left", "speed of the front left wheel", speed, 0.05, 150.0, front, left},
      {"wheel_front_right", "speed of the front right wheel", speed, 0.05, 150.0, front, right},
      {"wheel_rear_left", "speed of the rear left wheel", speed, 0.05, 150.0, rear, left},
      {"wheel_rear_right", "speed of the rear right wheel", speed, 0.05, 150.0, rear, right},
      {"wheel_rear", "speed of the rear axle", speed, 0.05, 150.0, rear},
      {"motor", "speed from the motor", speed, 0.05, 150.0, driven},
      {"steering", "steering angle", angle, 0.02, 1.4},  // below π/2, where tan diverges
      {"direction", "forward or reverse", direction, 0.5, 1.0},
      {"camera", "camera", pose, 1.0, 0.0},  // its poses state their own sigmas
  });
}();
static_assert(source_table.size() == source_count);

[[nodiscard]] constexpr std::size_t index_of(Source source) noexcept {
  return static_cast<std::size_t>(source);
}
[[nodiscard]] constexpr const SourceInfo& info_of(Source source) noexcept {
  return source_table[index_of(source)];
}

/// One property of all sources, in the order of Source.
template <class T>
[[nodiscard]] constexpr std::array<T, source_count> column(T SourceInfo::*property) {
  std::array<T, source_count> values{};
  std::ranges::transform(source_table, values.begin(), property);
  return values;
}
inline constexpr auto source_names = column(&SourceInfo::name);
inline constexpr auto default_sigma = column(&SourceInfo::sigma);
inline constexpr auto physical_limit = column(&SourceInfo::limit);

[[nodiscard]] constexpr bool is_inertial(Source source) noexcept {
  const Quantity quantity = info_of(source).quantity;
  return quantity == Quantity::yaw_rate || quantity == Quantity::acceleration;
}
/// Whether the source measures a speed: of a wheel, of an axle, or from the motor.
[[nodiscard]] constexpr bool is_wheel(Source source) noexcept {
  return info_of(source).quantity == Quantity::speed;
}
/// One of the four wheels, in contrast to an axle or the motor.
[[nodiscard]] constexpr bool is_single_wheel(Source source) noexcept {
  return info_of(source).side != Side::middle;
}
[[nodiscard]] constexpr bool is_front(Source wheel) noexcept {
  return info_of(wheel).axle == Axle::front;
}

/// A set of sources, one bit each.
using Sources = std::uint32_t;

[[nodiscard]] constexpr Sources only(Source source) noexcept {
  return Sources{1} << index_of(source);
}
[[nodiscard]] constexpr bool contains(Sources sources, Source source) noexcept {
  return (sources & only(source)) != 0;
}

inline constexpr auto all_sources = [] {
  std::array<Source, source_count> all{};
  for (std::size_t i = 0; i < source_count; ++i) {
    all[i] = static_cast<Source>(i);
  }
  return all;
}();

/// The sources that fulfil a condition.
[[nodiscard]] constexpr Sources set_of(const auto& is) noexcept {
  Sources set = 0;
  for (const Source source : all_sources) {
    set |= is(source) ? only(source) : 0;
  }
  return set;
}
inline constexpr Sources wheels = set_of(is_wheel);
inline constexpr auto wheel_sources = [] {
  std::array<Source, static_cast<std::size_t>(std::popcount(wheels))> list{};
  std::ranges::copy_if(all_sources, list.begin(), is_wheel);
  return list;
}();

/// Left and right wheel of the front and of the rear axle.
inline constexpr std::array wheel_pairs{
    std::pair{Source::wheel_front_left, Source::wheel_front_right},
    std::pair{Source::wheel_rear_left, Source::wheel_rear_right}};

}  // namespace odomd::estimator
