// One window of the fit: runs the model over it, and predicts the measurements.
#pragma once

#include <algorithm>
#include <cmath>
#include <vector>

#include "tools/identify/common/car_model.hpp"
#include "tools/identify/fit/drive.hpp"
#include "tools/identify/fit/parameters.hpp"

namespace odomd::tools::fitting {

/// A state of the model and the acceleration along x, dv_x/dt, at the same instant.
inline constexpr std::size_t node_size = car_model::states + 1;
template <class T>
using Node = std::array<T, node_size>;

/// Kinds of residuals: one per source, and those of poses.
inline constexpr std::size_t position_kind = estimator::source_count;
inline constexpr std::size_t yaw_kind = position_kind + 1;
inline constexpr std::size_t kinds = yaw_kind + 1;

/// The car before the fit, and the time steps.
struct Setup {
  const daemon::Config* config = nullptr;
  Numbers<double> nominal{};
  double step = 10e-3;  ///< step of integration [s]; this and `knot` are for a 1:10 car
  double knot = 50e-3;  ///< between two knots of the acceleration [s]
  double window = 0.5;  ///< [s], a whole number of knots
  double floor_speed = 0.02;
  double slow = 0.3;  ///< minimum speed for the tyre model [m/s]
  double wheelbase = 0.26;
  bool one_imu = false;  ///< accelerations come with the yaw rate, and have its latency
  std::array<double, kinds> noise{};  ///< of the residuals of each kind; 0: as stated

  [[nodiscard]] std::size_t knots() const {
    return static_cast<std::size_t>(std::lround(window / knot));
  }
  /// Unknowns inside a window: accelerations at the inner knots, steering errors at all knots.
  [[nodiscard]] std::size_t inner() const { return 2 * knots(); }
};

struct Window {
  const FitDrive* drive = nullptr;
  double begin = 0.0;
  double steering_sigma = 1e-3;  ///< difference of signal and wheel angle at one time [rad]
  std::vector<FitSample> samples;
  std::vector<PoseSample> poses;
};

/// The inputs of the car in a window, linear between knots.
template <class T>
struct Course {
  const T& begin;  ///< acceleration along x at the first knot
  const T* inner;  ///< accelerations at inner knots, then steering errors / steering_sigma at all
  const T& end;
  std::size_t last = 0;  ///< last knot

  [[nodiscard]] const T& accel(std::size_t k) const {
    return k == 0 ? begin : k == last ? end : inner[k - 1];
  }
  [[nodiscard]] const T& steering(std::size_t k) const { return inner[last - 1 + k]; }
};

inline double number(double value) {
  return value;
}
template <class T>
double number(const T& value) {
  return value.a;
}

/// The value of a signal at a time, which may be a jet.
template <class T>
T at(const Resampled& signal, const T& t) {
  constexpr double h = 5e-3;
  const double here = number(t);
  const double slope = (signal.at(here + h) - signal.at(here - h)) / (2.0 * h);
  return static_cast<T>(signal.at(here)) + slope * (t - here);
}

template <class T>
car_model::Car<T> car_of(const Setup& setup, const Numbers<T>& p) {
  using std::exp;
  const estimator::Vehicle& v = setup.config->vehicle;
  const auto scaled = [&](Parameter k) { return static_cast<T>(setup.nominal[k] * exp(p[k])); };
  car_model::Car<T> car;
  car.mass = static_cast<T>(v.mass);
  car.front_axle = static_cast<T>(v.front_axle);
  car.rear_axle = static_cast<T>(v.rear_axle);
  car.inertia = scaled(yaw_inertia);
  car.stiffness_front = scaled(stiffness_front);
  car.stiffness_rear = scaled(stiffness_rear);
  car.bend_front = scaled(bend_front);
  car.bend_rear = scaled(bend_rear);
  car.relaxation = scaled(relaxation_length);
  car.load_arm = scaled(load_arm);
  car.lag = scaled(steering_lag);
  car.spin = scaled(wheel_spin);
  car.load_lag = scaled(load_lag);
  car.track = v.track_width;
  car.floor_speed = setup.floor_speed;
  return car;
}

/// Substeps per step. Slip settles at the rate |v_x| / σ; Runge-Kutta diverges if rate · dt > 2.8.
[[nodiscard]] inline int stable_parts(double speed, double relaxation, double step) {
  constexpr double stable = 2.0, most = 64.0;
  const double parts = std::ceil(std::fabs(speed) / relaxation * step / stable);
  return static_cast<int>(std::fmin(std::fmax(parts, 1.0), most));  // 1 for NaN
}

/// The model's states on the grid of a window, one per step, and dv_x/dt at each.
template <class T>
struct Run {
  std::vector<car_model::State<T>> states;
  std::vector<T> accel;
};

template <class T>
Run<T> run(const Setup& setup, const Window& window, const Numbers<T>& p, const Node<T>& node,
           const Course<T>& course) {
  using std::exp;
  Run<T> result;
  const auto steps = static_cast<std::size_t>(std::lround(setup.window / setup.step));
  const car_model::Car<T> car = car_of(setup, p);
  const T gain = exp(-p[steering_scale]);
  // Only the total delay is observable: dead time and time constant are hardly separable.
  const T dead_time = setup.nominal[steering_delay] + p[steering_delay] - car.lag;
  const auto between = [&](auto value_at, double k) {
    const double place = k * setup.step / setup.knot;
    const auto i = std::min(static_cast<std::size_t>(place), course.last - 1);
    const T& from = (course.*value_at)(i);
    const T& to = (course.*value_at)(i + 1);
    return static_cast<T>(from + (place - static_cast<double>(i)) * (to - from));
  };
  const auto command_at = [&](double k) {
    const T signal =
        at(window.drive->steering, static_cast<T>(window.begin + k * setup.step - dead_time));
    return static_cast<T>(gain * (signal - p[steering_offset] +
                                  window.steering_sigma * between(&Course<T>::steering, k)));
  };
  car_model::State<T> x;
  std::copy_n(node.begin(), car_model::states, x.begin());
  result.states = {x};
  result.accel = {course.begin};
  for (std::size_t k = 0; k < steps; ++k) {
    const int parts = stable_parts(number(x[car_model::v_x]), number(car.relaxation), setup.step);
    T next = result.accel.back();
    for (int part = 0; part < parts; ++part) {
      const double begin = static_cast<double>(k) + static_cast<double>(part) / parts;
      const T before = next;
      next = between(&Course<T>::accel, begin + 1.0 / parts);
      x = car_model::step(car, x, command_at(begin + 0.5 / parts), before, next,
                          setup.step / parts);
    }
    result.states.push_back(x);
    result.accel.push_back(next);
  }
  return result;
}

/// The state between two grid points, or slightly beyond the ends.
template <class T>
struct Instant {
  car_model::State<T> x;
  T accel;
  T side_accel, turn, steer_rate;  ///< slopes of v_y, the yaw rate and the steering
};

template <class T>
Instant<T> instant(const Setup& setup, const Window& window, const Run<T>& run, const T& t) {
  const double place = (number(t) - window.begin) / setup.step;
  const std::size_t count = run.states.size();
  const auto i =
      static_cast<std::size_t>(std::clamp(std::floor(place), 0.0, static_cast<double>(count - 2)));
  const std::size_t before = i > 0 ? i - 1 : i, after = std::min(i + 2, count - 1);
  // Hermite cubic with slopes from the neighbours (Catmull-Rom), and its slope in u. Smooth, so
  // that the cost is smooth in the fitted latencies.
  const double u = std::clamp(place - static_cast<double>(i), -1.0, 2.0), u2 = u * u, u3 = u2 * u;
  const double h00 = 2 * u3 - 3 * u2 + 1, h10 = u3 - 2 * u2 + u, h01 = 3 * u2 - 2 * u3,
               h11 = u3 - u2;
  const double d00 = 6 * u2 - 6 * u, d10 = 3 * u2 - 4 * u + 1, d01 = -d00, d11 = 3 * u2 - 2 * u;
  const double left = i > 0 ? 0.5 : 1.0, right = i + 2 < count ? 0.5 : 1.0;
  // Weights of x_{i-1}, x_i, x_{i+1}, x_{i+2}; at the ends the slope is that of the last interval.
  const std::array<double, 4> w{-left * h10, h00 - right * h11, h01 + left * h10, right * h11};
  const std::array<double, 4> dw{-left * d10, d00 - right * d11, d01 + left * d10, right * d11};
  const T moved = t / setup.step - number(t) / setup.step;
  const auto mix = [&](const auto& of) {
    const T value = w[0] * of(before) + w[1] * of(i) + w[2] * of(i + 1) + w[3] * of(after);
    const double slope = dw[0] * number(of(before)) + dw[1] * number(of(i)) +
                         dw[2] * number(of(i + 1)) + dw[3] * number(of(after));
    return static_cast<T>(value + slope * moved);
  };
  const auto state = [&run](std::size_t k) {
    return [&run, k](std::size_t j) -> const T& { return run.states[j][k]; };
  };
  const auto slope = [&](std::size_t k) {
    const auto of = state(k);
    return static_cast<T>(
        (dw[0] * of(before) + dw[1] * of(i) + dw[2] * of(i + 1) + dw[3] * of(after)) / setup.step);
  };
  Instant<T> result;
  for (std::size_t k = 0; k < car_model::states; ++k) result.x[k] = mix(state(k));
  result.accel = mix([&run](std::size_t j) -> const T& { return run.accel[j]; });
  result.side_accel = slope(car_model::v_y);
  result.turn = slope(car_model::yaw_rate);
  result.steer_rate = slope(car_model::steer);
  return result;
}

/// The latency of a sample in addition to the configured one.
template <class T>
T latency_of(const Setup& setup, estimator::Source source, const Numbers<T>& p) {
  if (estimator::is_wheel(source)) return p[wheel_latency(source)];
  return p[setup.one_imu || source == estimator::Source::yaw_rate ? gyro_latency : accel_latency];
}

/// The specific force at the IMU, in its configured axes.
template <class T>
std::array<T, 2> measured_acceleration(const Setup& setup, const car_model::Car<T>& car,
                                       const Instant<T>& now, const Numbers<T>& p) {
  using std::cos;
  using std::exp;
  using std::sin;
  namespace st = car_model;
  const T accel_x = now.accel - now.x[st::v_y] * now.x[st::yaw_rate];
  const car_model::Push<T> push = car_model::push(car, now.x, accel_x);
  const T accel_y = push.side / car.mass;
  const T turn = push.moment / car.inertia;
  const T r2 = now.x[st::yaw_rate] * now.x[st::yaw_rate];
  const T px = setup.nominal[imu_x] + p[imu_x], py = setup.nominal[imu_y] + p[imu_y];
  const T ax = accel_x - turn * py - r2 * px;
  const T ay = accel_y + turn * px - r2 * py;
  const T c = cos(p[imu_yaw]), s = sin(p[imu_yaw]);
  const T scale = exp(p[accel_scale]);
  return {scale * (c * ax + s * ay) + p[accel_bias_x], scale * (c * ay - s * ax) + p[accel_bias_y]};
}

/// The speed of a wheel, or of the axle's middle, along its own direction.
//
// The force F of its tyre accelerates a wheel of spin inertia I / r² = m_w, so it slips: with C_κ =
// C / (2 p) per wheel, C its axle's cornering stiffness, and V its speed over the ground
//   ω r = V (1 + κ),   κ = F / C_κ,   F = T / r - m_w V̇
// In turns V̇ differs between the sides: the difference of the wheels then lags by m_w V / C_κ, as
// if their stamps were late.
template <class T>
T rolled(const Setup& setup, const car_model::Car<T>& car, estimator::Source source,
         const Instant<T>& now, const Numbers<T>& p) {
  using estimator::Source;
  using std::atan;
  using std::cos;
  using std::exp;
  using std::sin;
  using std::tan;
  namespace st = car_model;
  const T half = 0.5 * setup.nominal[track_width] * exp(p[track_width]);
  const T &r = now.x[st::yaw_rate], &forward = now.x[st::v_x];
  const T per_force = usual_slip + p[wheel_slip];
  const bool front = estimator::is_front(source);
  const estimator::Side on = estimator::info_of(source).side;
  const T out = (on == estimator::Side::left ? 1.0 : -1.0) * half;
  // The inner wheel has less load, and slips more.
  const T wheelbase = car.front_axle + car.rear_axle;
  const T share =
      1.0 + out * car.load_arm * wheelbase * forward * (r - car.load_lag * now.turn) /
                (st::gravity * 2.0 * half * half * (front ? car.rear_axle : car.front_axle));
  const T scale = exp(p[wheel_scale(source)]);
  if (front) {
    const T along = forward - out * r;
    const T side = now.x[st::v_y] + car.front_axle * r;
    // Ackermann: both front wheels turn about one centre, tan δ_i = l tan δ / (l - y_i tan δ)
    const T slope = tan(now.x[st::steer]);
    const T steer = atan(wheelbase * slope / (wheelbase - out * slope));
    const T c = cos(steer), s = sin(steer);
    const T speed = along * c + side * s;
    const T accel = (now.accel - out * now.turn) * c +
                    (now.side_accel + car.front_axle * now.turn) * s +
                    (side * c - along * s) * now.steer_rate;
    const T slip = per_force / setup.nominal[stiffness_front] * car.spin * car.mass * accel * share;
    return scale * speed * (static_cast<T>(1.0) - slip);
  }
  // κ = p D / C_h, with D the driving force
  const T accel_x = now.accel - now.x[st::v_y] * r;
  const T drive = car_model::push(car, now.x, accel_x).drive;
  const T per_newton = per_force / setup.nominal[stiffness_rear];
  if (on == estimator::Side::middle)
    return scale * forward * (static_cast<T>(1.0) + per_newton * drive);
  // Both wheels get the same torque, and the outer one spins up in a turn: F_i = D / 2 + m_w y_i ψ̈
  const T drive_spun = setup.nominal[drive_spin] * exp(p[drive_spin]) * car.mass;  // both wheels
  const T slip = per_newton * (drive + drive_spun * out * now.turn) * share;
  return scale * (forward - out * r) * (static_cast<T>(1.0) + slip);
}

/// The predicted measurement of a source.
template <class T>
T expected(const Setup& setup, const car_model::Car<T>& car, const FitSample& sample,
           const Instant<T>& now, const Numbers<T>& p) {
  using estimator::Source;
  using std::exp;
  switch (sample.source) {
    case Source::yaw_rate:
      return exp(p[gyro_scale]) * now.x[car_model::yaw_rate] + p[gyro_bias];
    case Source::accel_x:
    case Source::accel_y:
      return measured_acceleration(setup, car, now, p)[sample.source == Source::accel_y ? 1 : 0];
    default:
      return rolled(setup, car, sample.source, now, p);
  }
}

template <class T>
std::array<T, 3> expected_pose(const Setup& setup, const Instant<T>& now, const Numbers<T>& p) {
  using std::cos;
  using std::sin;
  namespace st = car_model;
  const T x = setup.nominal[camera_x] + p[camera_x], y = setup.nominal[camera_y] + p[camera_y];
  const T c = cos(now.x[st::yaw]), s = sin(now.x[st::yaw]);
  return {now.x[st::pos_x] + c * x - s * y, now.x[st::pos_y] + s * x + c * y,
          now.x[st::yaw] + setup.nominal[camera_yaw] + p[camera_yaw]};
}

/// Calls take(kind, measured less predicted, stated sigma) for every measurement of a window.
template <class T, class Take>
void for_each_residual(const Setup& setup, const Window& window, const Numbers<T>& p,
                       const Run<T>& run, Take&& take) {
  const car_model::Car<T> car = car_of(setup, p);
  for (const FitSample& sample : window.samples) {
    const T t = sample.t - latency_of(setup, sample.source, p);
    const T h = expected(setup, car, sample, instant(setup, window, run, t), p);
    take(estimator::index_of(sample.source), static_cast<T>(sample.value - h), sample.sigma);
  }
  for (const PoseSample& pose : window.poses) {
    const std::array<T, 3> h =
        expected_pose(setup, instant(setup, window, run, static_cast<T>(pose.t)), p);
    take(position_kind, static_cast<T>(pose.x - h[0]), pose.sigma_x);
    take(position_kind, static_cast<T>(pose.y - h[1]), pose.sigma_y);
    take(yaw_kind, static_cast<T>(pose.yaw - h[2]), pose.sigma_yaw);
  }
}

}  // namespace odomd::tools::fitting
