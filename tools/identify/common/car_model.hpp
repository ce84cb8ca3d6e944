// The car as `odom identify` fits it to a drive: a single-track model in continuous time with
// separate wheels. It has effects that the filters' model leaves out, as fitted parameters would
// otherwise absorb them: tyres that saturate, have a relaxation length, and change their load when
// the car turns, accelerates or brakes; wheels with rolling resistance and spin inertia.
//
// Templates of the scalar: doubles and Ceres's jets.
#pragma once

#include <array>
#include <cmath>
#include <cstddef>

namespace odomd::tools::car_model {

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
  T relaxation;                       ///< σ, distance over which a tyre builds up its force [m]
  T load_arm;              ///< p·h: height of the centre of gravity times the exponent p below [m]
  T lag;                   ///< time constant of the steering [s]
  T spin{};                ///< spin inertia of both front wheels / mass: I / (r² m)
  T load_lag{};            ///< time constant of the load transfer [s]
  double rolling = 0.015;  ///< rolling resistance / wheel load
  double track = 0.16;     ///< [m]
  double floor_speed = 0.1;  ///< lower speeds count as this in the build-up of slip [m/s]
};

/// Stiffness as a function of load: C(F_z) = C(F_z0) (F_z / F_z0)^p.
inline constexpr double load_exponent = 0.8;

/// The forces of the tyres on the car.
template <class T>
struct Push {
  T side;    ///< force to the left [N]
  T moment;  ///< about the vertical axis [N m]
  T drive;   ///< force of the rear tyres along x for a given acceleration [N]
};

// The side force of one tyre, with half of the axle's stiffness: C α / sqrt(1 + b (s² + s_x²)) with
// its load F_z = F_z0 (1 + ξ), s = C α / F_z, and s_x the driving force / F_z.
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

// Four tyres. Each axle has one slip that builds up; a wheel at y (left) has additional slip
// without lag: y sin²δ / l from Ackermann geometry, less its change of travel direction in a turn,
// y u_y ψ̇ / (u_x² + u_y²), u being the velocity of the axle's middle. At walking pace these two
// terms cancel.
//
// Loads: F_z0 of each wheel, m a_x h / (2 l) from front to rear, and m a_y h / (2 t) from the inner
// to the outer, where a_y = v_x (ψ̇ - τ ψ̈) lags, with ψ̈ of linear tyres. Rolling resistance is ρ
// F_z; the road also accelerates the front wheels' spin. All forces contribute to the yaw moment;
// those along the wheels have the lever arm y. J_z here includes the wheels' spin inertia, Σ I y² /
// r².
template <class T>
[[nodiscard]] Push<T> push(const Car<T>& car, const State<T>& x, const T& accel_x) {
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
  const T turned = s * s / wheelbase;  // extra steering per metre to the left
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

// v_x follows the given dv_x/dt; the steering follows `command` with its lag:
//   δ̇ = (δ_c - δ) / τ
//   slip:  α̇ = (-V_sy - V_t α) / σ,   V_sy = v'_y cos δ - v_x sin δ,  v'_y = v_y + l_v ψ̇
//   v̇_y = F_y / m - v_x ψ̇,  ψ̈ = M_z / J_z
// step() integrates the steering in closed form.
template <class T>
[[nodiscard]] State<T> rate_of(const Car<T>& car, const State<T>& x, const T& v_x_rate) {
  using std::cos;
  using std::sin;
  using std::sqrt;
  const T c = cos(x[steer]), s = sin(x[steer]);
  const T accel_x = v_x_rate - x[v_y] * x[yaw_rate];
  const Push<T> all = push(car, x, accel_x);
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

/// One Runge-Kutta step (fourth order); the steering in closed form, with constant δ_c.
template <class T>
[[nodiscard]] State<T> step(const Car<T>& car, const State<T>& x, const T& command,
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

/// The slowest speed at which a step of `dt` resolves the tyres' relaxation, with a margin.
[[nodiscard]] inline double floor_speed(double mass, double l_v, double l_h, double inertia,
                                        double c_v, double c_h, double dt) {
  const double fastest =
      std::fmax((c_v + c_h) / mass, (l_v * l_v * c_v + l_h * l_h * c_h) / inertia);
  return 0.7 * dt * fastest;
}

}  // namespace odomd::tools::car_model
