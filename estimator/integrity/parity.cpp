// docs/model.md, "Parities".
#include "estimator/integrity/parity.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

#include "estimator/common/squares.hpp"
#include "estimator/common/wheel_place.hpp"

namespace odomd::estimator::integrity {
namespace {

constexpr double skew_s = 0.01;  // between two sensors, on top of their cycles
// Lag of the front wheels behind the steering: of a sensor or a modelled servo; of a command.
constexpr double linkage_s = 0.05;
constexpr double servo_s = 0.1;
constexpr double camera_averaging_s = 0.15;

/// The observations, averaged over one of the two times.
struct View {
  const Sensors& sensors;
  const Observations& observed;
  Over over;

  [[nodiscard]] double speed() const noexcept { return observed.speed(over); }
  [[nodiscard]] double yaw_rate() const noexcept { return observed.yaw_rate(over); }
  [[nodiscard]] double mean(Source source) const noexcept {
    return observed.history(source).mean(over);
  }
  [[nodiscard]] double side() const noexcept { return lateral_accel(observed, over); }
  [[nodiscard]] bool slides(Source source) const noexcept {
    return observed.slides(observed.history(source).time_ns, over);
  }
  /// Error of a mean by its age. No car changes its speed faster.
  [[nodiscard]] double lateness(Source source) const noexcept {
    const SourceHistory& history = observed.history(source);
    const double most = is_wheel(source) ? largest_accel : std::numeric_limits<double>::infinity();
    const double late_s = source == Source::yaw_rate ? observed.errors.gyro_latency : 0.0;
    return (history.cycle_s + skew_s + late_s) * std::min(std::abs(history.rate(over)), most);
  }
  /// The mean of a product is not the product of the means: these two estimate the difference.
  [[nodiscard]] double speed_changed() const noexcept {
    return observed.speed() - observed.speed(over);
  }
  [[nodiscard]] double changed(Source source) const noexcept {
    const SourceHistory& history = observed.history(source);
    return history.mean() - history.mean(over);
  }
  [[nodiscard]] double noise(Source source) const noexcept {
    return observed.history(source).noise(over);
  }
};

/// Speed of a wheel's contact point, linear about (v_0, ψ̇_0): f = ± |(v - y ψ̇, l ψ̇)|.
Row wheel_row(const View& view, Source source, bool backwards) noexcept {
  const WheelPlace place = wheel_place(view.sensors.car, source);
  const double v = view.speed();
  const double r = view.yaw_rate();
  // A front wheel moves sideways with l ψ̇, as the rear axle does not slip.
  const double l = place.steered ? view.sensors.car.wheelbase() : 0.0;
  const double along = v - place.left * r;
  const double across = l * r;
  const double f = std::copysign(std::hypot(along, across), along);
  const bool still = std::abs(f) < 1e-3;
  const double by_v = still ? 1.0 : along / f;
  const double by_r = still ? -place.left : (l * across - place.left * along) / f;
  // Radii differ, and load transfer makes those of the outer wheels smaller.
  const double outer = -std::copysign(place.left == 0.0 ? 0.0 : 1.0, place.left) * v * r / gravity;
  const double mean = view.mean(source) /
                      (1.0 + view.observed.radius[index_of(source)] + view.observed.load * outer);
  const double hidden = std::abs(mean) < slowest_turning ? view.observed.errors.dead_band : 0.0;
  return {
      only(source),
      {by_v, by_r, place.steered ? 1.0 : 0.0, place.steered ? 0.0 : 1.0},
      (backwards ? -mean : mean) - f + by_v * v + by_r * r,
      root_of_squares(hidden, view.noise(source), 0.25 * view.observed.history(source).sigma,
                      view.sensors.tuning.wheel_radius * f,
                      view.observed.load_sigma * view.side() / gravity * f, view.lateness(source))};
}

/// ψ̇ = v tan δ / (l + K v²), K the understeer gradient.
Row steering_row(const View& view) noexcept {
  constexpr double share = 0.1;        // of the yaw rate: play, linkage
  constexpr double least_off = 0.005;  // [rad]
  constexpr double floor = 0.02;       // [rad/s]
  constexpr double slowest = 0.5;      // [m/s]
  const Vehicle& car = view.sensors.car;
  // From this lateral acceleration on the front may slide [m/s²]. A driver who loses the car does
  // not hold the steering still.
  const double sliding = view.observed.history(Source::steering).repeats() ? 5.0 : 2.5;
  const double l = car.wheelbase();
  const double gradient = car.mass *
                          (car.rear_axle * car.cornering_stiffness_rear -
                           car.front_axle * car.cornering_stiffness_front) /
                          (l * car.cornering_stiffness_front * car.cornering_stiffness_rear);
  const double v = view.speed();
  const SensorErrors& errors = view.observed.errors;
  const double tangent =
      std::tan(std::clamp(view.mean(Source::steering) - errors.steering_offset, -1.4, 1.4));
  const double most = v * tangent / std::max(0.5 * l, l + std::min(gradient, 0.0) * v * v);
  const double least = std::abs(v * most) > sliding
                           ? 0.0
                           : v * tangent / (l + 1.5 * std::max(gradient, 0.0) * v * v);
  const double by_v = (1.0 + tangent * tangent) / l;
  const double by_delta = std::abs(v) * by_v;
  // Response time of the car to its steering: ψ̈ = -ψ̇ (l_v² C_v + l_h² C_h) / (J_z v) + ...
  const double response_s = car.yaw_inertia * std::abs(v) /
                            (car.front_axle * car.front_axle * car.cornering_stiffness_front +
                             car.rear_axle * car.rear_axle * car.cornering_stiffness_rear);
  // In a slide the driver countersteers.
  const double counter = view.slides(Source::steering)
                             ? std::max(std::abs(view.yaw_rate()),
                                        sliding_accel / std::max(std::abs(view.speed()), slowest))
                             : 0.0;
  // A command is an intention that the wheels follow.
  const bool modelled = car.steering.lag_s > 0.0 || car.steering.rate_limit > 0.0;
  const double changed = view.changed(Source::steering);
  const double fastest_change =
      std::max(std::abs(view.observed.history(Source::steering).rate(view.over)),
               std::abs(changed) / seconds_of(view.over));
  const double lateness = view.lateness(Source::steering) +
                          ((modelled ? linkage_s : servo_s) + response_s) * fastest_change;
  const double offset = std::max(least_off, errors.steering_offset_sigma);
  // tan δ / l is ∂ψ̇/∂v of a car without understeer.
  return {only(Source::steering),
          {-tangent / l, 1.0, 0.0, 0.0},
          0.5 * (most + least) - tangent / l * v,
          root_of_squares(by_delta * view.noise(Source::steering), by_delta * offset,
                          by_delta * lateness, share * most, 0.5 * (most - least), counter, floor,
                          by_v * changed * view.speed_changed())};
}

Row gyro_row(const View& view) noexcept {
  constexpr double least_off = 0.01;  // [rad/s]
  const SensorErrors& errors = view.observed.errors;
  const double z = view.mean(Source::yaw_rate) - errors.gyro_bias;
  return {only(Source::yaw_rate),
          {0.0, 1.0, 0.0, 0.0},
          z,
          root_of_squares(view.noise(Source::yaw_rate), std::max(least_off, errors.gyro_bias_sigma),
                          view.sensors.tuning.gyro_scale * z, view.lateness(Source::yaw_rate))};
}

/// a_y = v ψ̇, linear about (v_0, ψ̇_0). In a slide v̇_y is not small.
Row accel_y_row(const View& view) noexcept {
  constexpr double bank = 0.05;  // [g]
  const double demanded = view.speed() * view.yaw_rate();
  return {
      only(Source::accel_y),
      {view.yaw_rate(), view.speed(), 0.0, 0.0},
      view.mean(Source::accel_y) + demanded,
      root_of_squares(
          view.noise(Source::accel_y), view.sensors.tuning.accel_bias, bank * gravity,
          view.sensors.tuning.roll_gradient * view.side(), view.lateness(Source::accel_y),
          view.slides(Source::accel_y) ? 0.5 * std::max(std::abs(demanded), sliding_accel) : 0.0,
          view.changed(Source::yaw_rate) * view.speed_changed())};
}

}  // namespace

bool is_steady(const SourceHistory& gyro) noexcept {
  constexpr double swing = 0.02;  // [rad/s], and two sigmas
  return std::abs(gyro.mean()) < largest_gyro_bias &&
         std::abs(gyro.mean() - gyro.mean(Over::long_time)) < swing + 2.0 * gyro.sigma;
}

double lateral_accel(const Observations& observed, Over over) noexcept {
  const double demanded = observed.speed(over) * observed.yaw_rate(over);
  const double measured =
      observed.usable(Source::accel_y) ? observed.history(Source::accel_y).mean(over) : demanded;
  return demanded * measured > 0.0 ? std::min(std::abs(demanded), std::abs(measured)) : 0.0;
}

Consensus parities(const Sensors& sensors, const Observations& observed, bool backwards,
                   Over over) noexcept {
  constexpr double slip_floor = 0.02;  // [m/s]
  constexpr double slip_share = 0.01;
  const View view{sensors, observed, over};
  Consensus all;
  // 1. Prior knowledge: how fast a car can change its motion, and how much wheels slip.
  const double hold_s = 0.03 + seconds_of(over) - seconds_of(Over::short_time);
  const double v = view.speed();
  all.add({0,
           {1.0, 0.0, 0.0, 0.0},
           v,
           root_of_squares(observed.last_consensus.front().sigma[of::speed],
                           gravity * (hold_s + observed.speed_unknown_s))});
  all.add({0,
           {0.0, 1.0, 0.0, 0.0},
           view.yaw_rate(),
           sensors.tuning.turn_in * gravity / sensors.car.wheelbase() * 3.0 * hold_s});
  // Driven wheels slip, and all that brake, in proportion to the acceleration: the smaller one of
  // accelerometer and wheels.
  double faster = 0.0;
  for (const Source wheel : wheel_sources) {
    const double rate = observed.history(wheel).rate(over);
    if (observed.usable(wheel) && std::abs(rate) > std::abs(faster)) {
      faster = rate;
    }
  }
  const double measured = observed.usable(Source::accel_x)
                              ? std::abs(view.mean(Source::accel_x) - observed.accel_offset)
                              : std::abs(faster);
  const double accel = std::min(measured, std::abs(faster));
  const bool brakes = faster * v < 0.0;
  const auto slip = [&](Source wheel) {
    const bool slips = brakes || is_driven(sensors.car.driven, wheel);
    return root_of_squares(slip_floor, slip_share * v,
                           slips ? observed.errors.wheel_slip * accel * v : 0.0);
  };
  all.add({0, {0.0, 0.0, 1.0, 0.0}, 0.0, slip(Source::wheel_front_left)});
  all.add({0, {0.0, 0.0, 0.0, 1.0}, 0.0, slip(Source::wheel_rear_left)});

  // 2. The sources.
  const auto has_mean = [&](const SourceHistory& history) {
    return history.alive(observed.now_ns) &&
           (over == Over::short_time || history.duration_s() >= 2.0 * seconds_of(over));
  };
  const auto alive = [&](Source source) { return has_mean(observed.history(source)); };
  int turning = 0;
  int standing = 0;
  for (const Source wheel : wheel_sources) {
    if (alive(wheel)) {
      if (observed.usable(wheel)) {
        ++(std::abs(observed.history(wheel).mean()) < slowest_turning ? standing : turning);
      }
      all.add(wheel_row(view, wheel, backwards));
    }
  }
  const bool stands = standing > 0 && turning == 0;
  if (alive(Source::yaw_rate) && !(stands && is_steady(observed.history(Source::yaw_rate)))) {
    all.add(gyro_row(view));
  }
  if (alive(Source::steering)) {
    all.add(steering_row(view));
  }
  if (alive(Source::accel_y)) {
    all.add(accel_y_row(view));
  }
  if (alive(Source::accel_x) && over == Over::short_time) {
    all.add({only(Source::accel_x),
             {1.0, 0.0, 0.0, 0.0},
             observed.integrated_speed,
             observed.integrated_sigma});
  }
  if (has_mean(observed.camera_speed)) {
    constexpr double share = 0.05;
    constexpr double floor = 0.03;  // [m/s, rad/s]
    // The noise of a mean rate is that of the position over the averaging time.
    const SourceHistory& speed = observed.camera_speed;
    const double seconds =
        std::min(std::max(camera_averaging_s, seconds_of(over)), speed.duration_s() + 1e-3);
    const double age_s = camera_averaging_s + seconds_between(speed.time_ns, observed.now_ns);
    const double noise = std::sqrt(observed.errors.camera_noise_scale) / seconds;
    const auto add = [&](const Motion& by, const SourceHistory& rate, double last) {
      all.add({only(Source::camera), by, rate.mean(over),
               root_of_squares(floor + share * std::abs(last), rate.sigma * noise,
                               age_s * rate.rate(over))});
    };
    add({1.0, 0.0, 0.0, 0.0}, speed, v);
    add({0.0, 1.0, 0.0, 0.0}, observed.camera_yaw_rate, view.yaw_rate());
  }
  return all;
}

void learn_radii(const Sensors& sensors, const Consensus& all, const Solution& base, double dt,
                 Observations& observed) noexcept {
  constexpr double learnt_s = 20.0;
  constexpr double most = 0.02;
  constexpr double load_known = 0.002;
  const double v = base.motion[of::speed];
  if (std::abs(v) < min_learning_speed) {
    return;
  }
  const double side = v * base.motion[of::yaw_rate] / gravity;
  for (const Row& row : all) {
    for (const Source wheel : wheel_sources) {
      if (row.sources != only(wheel)) {
        continue;
      }
      const double error = row.off(base.motion) * row.sigma / v;
      double& radius = observed.radius[index_of(wheel)];
      radius = std::clamp(radius + dt / learnt_s * error, -most, most);
      const double left = wheel_place(sensors.car, wheel).left;
      if (left != 0.0) {
        observed.load =
            std::clamp(observed.load - std::copysign(dt, left) * side * error, -most, most);
      }
    }
  }
  const double unknown = observed.load_sigma - load_known;
  observed.load_sigma -= std::min(2.0 * dt * side * side, 1.0) * unknown;
}

}  // namespace odomd::estimator::integrity
