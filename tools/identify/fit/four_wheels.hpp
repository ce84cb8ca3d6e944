// The single-track car with separate wheels, as `odom identify fit` fits it to a drive: each tyre
// with its own load and slip, wheels with rolling resistance and spin inertia;
// and the brush tyres of the filter that are like its own (docs/model.md, "Tyres").
//
// Templates over the scalar: doubles, and Ceres's jets.
#pragma once

#include <cmath>
#include <cstdint>
#include <optional>

#include "tools/identify/common/single_track.hpp"

namespace odomd::tools::four_wheels {

using single_track::gravity;
using single_track::slip_front;
using single_track::slip_rear;
using single_track::steer;
using single_track::v_x;
using single_track::v_y;
using single_track::yaw_rate;

/// `load_arm` is p·h of all wheels, p the exponent below.
template <class T>
struct Car : single_track::Car<T> {
  T spin{};      ///< spin of the front wheels, as a share of the mass: I / r² of both
  T load_lag{};  ///< time constant of the load transfer [s]
};

/// Stiffness over load: C(F_z) = C(F_z0) (F_z / F_z0)^p.
inline constexpr double load_exponent = 0.8;

/// The forces of the tyres on the car.
template <class T>
struct Push {
  T side;    ///< force to the left [N]
  T moment;  ///< about the vertical axis [N m]
  T drive;   ///< force of the rear tyres along x for this acceleration [N]
};

// The side force of one tyre, of half an axle's stiffness. Its load F_z = F_z0 (1 + ξ), and with
// s = C α / F_z and the driving force's own share s_x of the load
//   F = C α / √(1 + b (s² + s_x²)),   C = (C_axle / 2) (1 + p ξ - p (1 - p) ξ² / 2)
template <class T>
[[nodiscard]] T tyre_force(const T& axle_stiffness, const T& bend, const T& static_load,
                           const T& shift, const T& slip, const T& drive) {
  using std::sqrt;
  constexpr double p = load_exponent;
  const T linear =
      0.5 * axle_stiffness * (1.0 + p * shift - 0.5 * p * (1.0 - p) * shift * shift) * slip;
  const T load = static_load * (1.0 + shift);
  return linear / sqrt(1.0 + bend * (linear * linear + drive * drive) / (load * load));
}

// Four tyres, each axle with one slip that builds up and, at once, what a wheel y to the left of
// the middle has more of it. Ackermann's geometry steers it by y sin²δ / l more, and in a turn it
// rolls by y u_y ψ̇ / (u_x² + u_y²) in another direction, u the velocity of the axle's middle; at
// walking pace the one is the other.
//
// Loads: F_z0 of each wheel, m a_x h / (2 l) from front to rear, and m a_y h / (2 t) from the inner
// to the outer, where a_y = v_x (ψ̇ - τ ψ̈) lags, ψ̈ by linear tyres. Wheels roll against ρ F_z, and
// the front ones are sped up by the road. All forces turn the car by their arms, those along the
// wheels by y. What the wheels' spin adds to the yaw inertia, Σ I y² / r², is part of J_z here.
template <class T>
[[nodiscard]] Push<T> push(const Car<T>& car, const single_track::State<T>& x, const T& accel_x) {
  using std::cos;
  using std::sin;
  using std::sqrt;
  const T wheelbase = car.front_axle + car.rear_axle;
  const T weight = car.mass * gravity;
  const T load_front = 0.5 * weight * car.rear_axle / wheelbase;
  const T load_rear = 0.5 * weight * car.front_axle / wheelbase;
  const T transfer = 0.5 * car.mass * car.load_arm / load_exponent;  // m h / 2
  const T along = transfer * accel_x / wheelbase;
  const T yaw_accel = (car.front_axle * car.stiffness_front * x[slip_front] -
                       car.rear_axle * car.stiffness_rear * x[slip_rear]) /
                      car.inertia;
  const T across = transfer * x[v_x] * (x[yaw_rate] - car.load_lag * yaw_accel) / car.track;
  const T spun = 0.5 * car.spin * car.mass * accel_x;

  const T s = sin(x[steer]), c = cos(x[steer]);
  const double least = car.floor_speed * car.floor_speed;
  const T pace2 = x[v_x] * x[v_x] + least;
  const T rolling = car.rolling * x[v_x] / sqrt(pace2);
  const T side_front = x[v_y] + car.front_axle * x[yaw_rate];
  const T turned = s * s / wheelbase;  // of the wheel, a metre to the left
  const T more_front = turned - side_front * x[yaw_rate] / (pace2 + side_front * side_front);
  const T more_rear = x[slip_rear] * x[v_x] * x[yaw_rate] / pace2;

  Push<T> all{
      .side = static_cast<T>(0.0), .moment = static_cast<T>(0.0), .drive = car.mass * accel_x};
  for (const double part : {0.5, -0.5}) {
    const T y = static_cast<T>(part * car.track);
    const T shift = (-along - 2.0 * part * across) / load_front;
    const T force = tyre_force(car.stiffness_front, car.bend_front, load_front, shift,
                               static_cast<T>(x[slip_front] + y * more_front), static_cast<T>(0.0));
    const T drag = rolling * load_front * (1.0 + shift) + spun;
    const T sy = s + c * y * turned, cy = c - s * y * turned;
    const T to_the_left = force * cy - drag * sy;
    const T backwards = force * sy + drag * cy;
    all.side += to_the_left;
    all.moment += car.front_axle * to_the_left + y * backwards;
    all.drive += backwards;
  }
  all.drive += 2.0 * rolling * (load_rear + along);
  for (const double part : {0.5, -0.5}) {
    const T y = static_cast<T>(part * car.track);
    const T shift = (along - 2.0 * part * across) / load_rear;
    const T force =
        tyre_force(car.stiffness_rear, car.bend_rear, load_rear, shift,
                   static_cast<T>(x[slip_rear] + y * more_rear), static_cast<T>(0.5 * all.drive));
    all.side += force;
    all.moment += y * rolling * load_rear * (1.0 + shift) - car.rear_axle * force;
  }
  return all;
}

}  // namespace odomd::tools::four_wheels

namespace odomd::tools::fitting {

enum class Axle : std::uint8_t { front, rear };

struct BrushTyre {
  double stiffness = 0.0;  ///< C, of the whole axle at no slip [N/rad]
  double grip = 0.0;       ///< F_max by the axle's share of the mass [m/s²]
};

/// The slip angle [rad] at which an axle carries its share of the car in a steady turn of this
/// lateral acceleration [m/s²], above 0. Infinite if it cannot, or slips by more than 45°.
[[nodiscard]] double slip_at(const four_wheels::Car<double>& car, Axle axle, double accel);

/// The brush tyre that slips as the axle does at this lateral acceleration [m/s²] and at a half of
/// it. Nothing if the axle does not saturate, or cannot carry that.
[[nodiscard]] std::optional<BrushTyre> brush_like(const four_wheels::Car<double>& car, Axle axle,
                                                  double accel);

}  // namespace odomd::tools::fitting
