// The car as `odom identify` fits it to a drive: a single-track model in continuous time with
// effects that the filters' model leaves out, because fitted parameters would otherwise absorb
// them: tyres that saturate, have a relaxation length, and change their load when the car
// accelerates or brakes.
//
// Templates over the scalar: doubles, and Ceres's jets.
#pragma once

#include <array>
#include <cmath>
#include <cstddef>

namespace odomd::tools::single_track {

inline constexpr double gravity = 9.80665;

/// Indices in the state.
enum : std::size_t { pos_x, pos_y, yaw, v_x, v_y, yaw_rate, steer, slip_front, slip_rear, states };

template <class T>
using State = std::array<T, states>;

template <class T>
struct Car {
  T mass, front_axle, rear_axle, inertia;
  T stiffness_front, stiffness_rear;  ///< at zero slip under static load [N/rad]
  T bend_front, bend_rear;            ///< b below: 0 is linear
  T relaxation;                       ///< σ, way on which a tyre builds up its force [m]
  T load_arm;  ///< p·h: height of the centre of gravity times the load exponent of the stiffness
               ///< [m]
  T lag;       ///< time constant of the steering [s]
  double rolling = 0.015;    ///< resistance of the wheels, by their load
  double track = 0.16;       ///< [m]
  double floor_speed = 0.1;  ///< below it slip builds up as if at it [m/s]
};

/// Side forces of the tyres, in their own axes [N].
template <class T>
struct Forces {
  T front, rear;
};

// Static axle loads F_zv = m g l_h / l, F_zh = m g l_v / l; the load that acceleration moves to the
// rear changes the stiffnesses by -p a_x h / (g l_h) and +p a_x h / (g l_v). With s = C α / F_z and
// the driving force's own share s_x of the load,
//   F = C α / √(1 + b (s² + s_x²))
template <class T>
[[nodiscard]] Forces<T> forces(const Car<T>& car, const State<T>& x, const T& accel_x) {
  using std::sqrt;
  const T wheelbase = car.front_axle + car.rear_axle;
  const T load_front = car.mass * gravity * car.rear_axle / wheelbase;
  const T load_rear = car.mass * gravity * car.front_axle / wheelbase;
  const T shift = car.load_arm * accel_x / gravity;
  const T linear_front = car.stiffness_front * (T(1.0) - shift / car.rear_axle) * x[slip_front];
  const T linear_rear = car.stiffness_rear * (T(1.0) + shift / car.front_axle) * x[slip_rear];
  const T s_front = linear_front / load_front;
  const T s_rear = linear_rear / load_rear;
  const T driven = car.mass * accel_x / load_rear;
  return {linear_front / sqrt(T(1.0) + car.bend_front * s_front * s_front),
          linear_rear / sqrt(T(1.0) + car.bend_rear * (s_rear * s_rear + driven * driven))};
}

/// Their effect on the car: the force to the left and the moment about the vertical axis.
template <class T>
struct Push {
  T side, moment;
};

// Steered wheels roll against their resistance, and pull the car out of the turn by its part
// across. They share their force unevenly: the outer one, more loaded by x = p h l a_y / (g t l_h),
// takes more, and by Ackermann's geometry the inner one is steered by t δ² / l more. What they pull
// back with, F sin δ, then turns the car, at half the track width:
//   M = (t/2) sin δ (C_v t δ² / (2 l) - x F_v)
template <class T>
[[nodiscard]] Push<T> push(const Car<T>& car, const State<T>& x, const T& accel_x) {
  using std::cos;
  using std::sin;
  using std::sqrt;
  const Forces<T> f = forces(car, x, accel_x);
  const T wheelbase = car.front_axle + car.rear_axle;
  const T s = sin(x[steer]), c = cos(x[steer]);
  const T forward = x[v_x] / sqrt(x[v_x] * x[v_x] + car.floor_speed * car.floor_speed);
  const T drag = car.rolling * car.mass * gravity * car.rear_axle / wheelbase * forward;
  const T front = f.front * c - drag * s;
  const T outer = car.load_arm * wheelbase * (f.front + f.rear) /
                  (car.mass * gravity * car.track * car.rear_axle);
  const T inner = car.stiffness_front * car.track * s * s / (2.0 * wheelbase);
  return {front + f.rear, car.front_axle * front - car.rear_axle * f.rear +
                              0.5 * car.track * s * (inner - outer * f.front)};
}

// v_x follows the given dv_x/dt; the steering by its lag towards `command`:
//   δ̇ = (δ_c - δ) / τ
//   slip:  α̇ = (-V_sy - V_t α) / σ,   V_sy = v'_y cos δ - v_x sin δ,  v'_y = v_y + l_v ψ̇
//   v̇_y = F_y / m - v_x ψ̇,  ψ̈ = M_z / J_z
// The steering is left to step(), which knows its solution. The forces are push() of the car's
// kind.
template <template <class> class AnyCar, class T>
[[nodiscard]] State<T> rate_of(const AnyCar<T>& car, const State<T>& x, const T& v_x_rate) {
  using std::cos;
  using std::sin;
  using std::sqrt;
  const T c = cos(x[steer]), s = sin(x[steer]);
  const T accel_x = v_x_rate - x[v_y] * x[yaw_rate];
  const auto all = push(car, x, accel_x);
  const T side = x[v_y] + car.front_axle * x[yaw_rate];
  const T along = x[v_x] * c + side * s;
  const double least = car.floor_speed * car.floor_speed;
  const T rolling_front = sqrt(along * along + least);
  const T rolling_rear = sqrt(x[v_x] * x[v_x] + least);
  const T cy = cos(x[yaw]), sy = sin(x[yaw]);
  State<T> d;
  d[pos_x] = x[v_x] * cy - x[v_y] * sy;
  d[pos_y] = x[v_x] * sy + x[v_y] * cy;
  d[yaw] = x[yaw_rate];
  d[v_x] = v_x_rate;
  d[v_y] = all.side / car.mass - x[v_x] * x[yaw_rate];
  d[yaw_rate] = all.moment / car.inertia;
  d[steer] = static_cast<T>(0.0);
  d[slip_front] = (x[v_x] * s - side * c - rolling_front * x[slip_front]) / car.relaxation;
  d[slip_rear] =
      (car.rear_axle * x[yaw_rate] - x[v_y] - rolling_rear * x[slip_rear]) / car.relaxation;
  return d;
}

/// One step of Runge and Kutta (fourth order); the steering in closed form, δ_c held.
template <template <class> class AnyCar, class T>
[[nodiscard]] State<T> step(const AnyCar<T>& car, const State<T>& x, const T& command,
                            const T& accel_begin, const T& accel_end, double dt) {
  using std::exp;
  const T half_decay = exp(static_cast<T>(-0.5 * dt) / car.lag);
  const T steer_half = command + (x[steer] - command) * half_decay;
  const T steer_end = command + (steer_half - command) * half_decay;
  const T accel_half = static_cast<T>(0.5) * (accel_begin + accel_end);
  const auto moved = [&x](const State<T>& k, double h, const T& steering) {
    State<T> result;
    for (std::size_t i = 0; i < states; ++i) result[i] = x[i] + h * k[i];
    result[steer] = steering;
    return result;
  };
  const State<T> k1 = rate_of(car, x, accel_begin);
  const State<T> k2 = rate_of(car, moved(k1, 0.5 * dt, steer_half), accel_half);
  const State<T> k3 = rate_of(car, moved(k2, 0.5 * dt, steer_half), accel_half);
  const State<T> k4 = rate_of(car, moved(k3, dt, steer_end), accel_end);
  State<T> result;
  for (std::size_t i = 0; i < states; ++i)
    result[i] = x[i] + (dt / 6.0) * (k1[i] + 2.0 * k2[i] + 2.0 * k3[i] + k4[i]);
  result[steer] = steer_end;
  return result;
}

/// The slowest speed at which a step of `dt` resolves the settling of the tyres, with a margin.
[[nodiscard]] inline double floor_speed(double mass, double l_v, double l_h, double inertia,
                                        double c_v, double c_h, double dt) {
  const double fastest =
      std::fmax((c_v + c_h) / mass, (l_v * l_v * c_v + l_h * l_h * c_h) / inertia);
  return 0.7 * dt * fastest;
}

}  // namespace odomd::tools::single_track
