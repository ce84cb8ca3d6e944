// docs/model.md, "Equations".
#include "estimator/integrity/equations.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

#include "estimator/common/symmetric3.hpp"
#include "estimator/common/vehicle.hpp"
#include "estimator/integrity/admission.hpp"

namespace odomd::estimator::integrity {
namespace {

constexpr double skew_s = 0.01;  // time between two sensors' samples, in addition to their cycles
// Lag of the front wheels behind a sensor or a modelled servo, and behind a command [s].
constexpr double linkage_s = 0.05;
constexpr double servo_s = 0.1;
constexpr double camera_averaging_s = 0.15;

/// The mean of a source, and its errors.
struct Averaged {
  double mean;
  double noise;
  double lateness;  ///< error of the mean due to its age
  double changed;   ///< the short mean minus this one
  bool slides;      ///< the car may have slid meanwhile
};

/// The observations, averaged over one of the two averaging times.
struct View {
  const Sensors& sensors;
  const Observations& observed;
  Over over;
  double v = observed.speed(over);     ///< from the last consensus
  double r = observed.yaw_rate(over);  ///< from the last consensus
  double side = lateral_accel(observed, over);
  /// The mean of a product is not the product of the means: this and `Averaged::changed` estimate
  /// the difference.
  double speed_changed = observed.speed() - v;

  [[nodiscard]] Averaged average(Source source) const noexcept {
    const SourceHistory& history = observed.history(source);
    const double fastest = is_wheel(source) ? largest_accel : HUGE_VAL;
    const double late_s = source == Source::yaw_rate ? observed.errors.gyro_latency : 0.0;
    return {history.mean(over), history.noise(over),
            (history.cycle_s + skew_s + late_s) * std::min(std::abs(history.rate(over)), fastest),
            history.mean() - history.mean(over), observed.slides(history.time_ns, over)};
  }
};

/// A wheel rolls with the velocity at its position along δ_i:
/// (v - y ψ̇) cos δ_i + (u + l ψ̇) sin δ_i, u being the rear axle's lateral speed.
/// tan δ_i = l tan δ / (l - y tan δ) (Ackermann); without a steering signal, the velocity's
/// direction.
Row wheel_row(const View& view, Source source, bool backwards) noexcept {
  constexpr double lasting_share = 0.25;  // share of a sample's noise that does not average out
  constexpr double slowest = 1e-3;        // [m/s]
  const WheelPlace place = wheel_place(view.sensors.car, source);
  const SensorErrors& errors = view.observed.errors;
  const SourceHistory& history = view.observed.history(source);
  const Averaged wheel = view.average(source);
  const double l = place.steered ? view.sensors.car.wheelbase() : 0.0;
  const double along = view.v - place.left * view.r;
  const double across = place.steered ? errors.rear_slip + l * view.r : 0.0;
  double delta = 0.0;
  if (place.steered && view.observed.usable(Source::steering)) {
    const double measured = view.average(Source::steering).mean - errors.steering_offset;
    delta = std::atan2(l * std::sin(measured),
                       l * std::cos(measured) - place.left * std::sin(measured));
  } else if (std::abs(along) >= slowest) {
    delta = std::atan(across / along);
  }
  const double c = std::cos(delta);
  const double s = std::sin(delta);
  const double rolls = along * c + across * s;
  const double mean = wheel.mean / (1.0 + view.observed.radius[index_of(source)]);
  const double hidden =
      std::abs(history.value) < slowest_turning ? errors.dead_band[index_of(source)] : 0.0;
  // The rolling speed of a wheel that slides sideways is less certain.
  const double slides = 0.5 * (std::hypot(along, across) - std::abs(rolls));
  // Radii differ; load transfer adds an equal difference at 1 g.
  const double unequal =
      view.sensors.tuning.wheel_radius * rolls * std::hypot(1.0, view.side / gravity);
  const double sigma =
      root_of_squares(hidden, slides, s * errors.rear_slip_sigma, view.observed.slip_sigma(source),
                      wheel.noise, lasting_share * history.sigma, unequal, wheel.lateness);
  const Motion by{c, l * s - place.left * c, place.steered ? 1.0 : 0.0, place.steered ? 0.0 : 1.0};
  return {only(source), by, (backwards ? -mean : mean) - errors.rear_slip * s, sigma};
}

/// ψ̇ = v tan δ / (l + K v²), K the understeer gradient.
Row steering_row(const View& view) noexcept {
  constexpr double share = 0.1;        // relative error of the yaw rate, from play and linkage
  constexpr double least_off = 0.005;  // [rad]
  constexpr double floor = 0.02;       // [rad/s]
  constexpr double slowest = 0.5;      // [m/s]
  constexpr double understeer = 1.5;   // largest ratio of the true gradient to the stated one
  const Vehicle& car = view.sensors.car;
  constexpr double largest = physical_limit[index_of(Source::steering)];
  const SourceHistory& history = view.observed.history(Source::steering);
  const Averaged steering = view.average(Source::steering);
  // Above this lateral acceleration the front may slide [m/s²]. It is higher while the steering is
  // held, because a driver who loses control moves it.
  const double sliding = history.repeats() ? 5.0 : 2.5;
  const double l = car.wheelbase();
  const double c_v = car.cornering_stiffness_front;
  const double c_h = car.cornering_stiffness_rear;
  const double gradient = car.mass * (car.rear_axle * c_h - car.front_axle * c_v) / (l * c_v * c_h);
  const double v = view.v;
  const double offset = view.observed.errors.steering_offset;
  const double tangent = std::tan(std::clamp(steering.mean - offset, -largest, largest));
  const double most = v * tangent / std::max(0.5 * l, l + std::min(gradient, 0.0) * v * v);
  const double least = std::abs(v * most) > sliding
                           ? 0.0
                           : v * tangent / (l + understeer * std::max(gradient, 0.0) * v * v);
  const double by_v = (1.0 + tangent * tangent) / l;
  const double by_delta = std::abs(v) * by_v;
  // Response time of the car to its steering: ψ̈ = -ψ̇ (l_v² C_v + l_h² C_h) / (J_z v) + ...
  const double response_s =
      car.yaw_inertia * std::abs(v) /
      (car.front_axle * car.front_axle * c_v + car.rear_axle * car.rear_axle * c_h);
  // In a slide the driver countersteers.
  const double counter =
      steering.slides ? std::max(std::abs(view.r), sliding_accel / std::max(std::abs(v), slowest))
                      : 0.0;
  // The wheels lag behind a bare command more than behind a modelled actuator.
  const bool modelled = car.steering.lag_s > 0.0 || car.steering.rate_limit > 0.0;
  const double fastest_change = std::max(std::abs(history.rate(view.over)),
                                         std::abs(steering.changed) / seconds_of(view.over));
  const double lateness =
      steering.lateness + ((modelled ? linkage_s : servo_s) + response_s) * fastest_change;
  const double offset_sigma = std::max(least_off, view.observed.errors.steering_offset_sigma);
  const double sigma = root_of_squares(
      by_delta * steering.noise, by_delta * offset_sigma, by_delta * lateness, share * most,
      0.5 * (most - least), counter, floor, by_v * steering.changed * view.speed_changed);
  // tan δ / l is ∂ψ̇/∂v of a car without understeer.
  const Motion by{-tangent / l, 1.0, 0.0, 0.0};
  return {only(Source::steering), by, 0.5 * (most + least) - tangent / l * v, sigma};
}

Row gyro_row(const View& view) noexcept {
  constexpr double least_off = 0.01;  // [rad/s]
  const Averaged gyro = view.average(Source::yaw_rate);
  const double z = gyro.mean - view.observed.errors.gyro_bias;
  return {only(Source::yaw_rate), Motion::Unit(of::yaw_rate), z,
          root_of_squares(gyro.noise, std::max(least_off, view.observed.errors.gyro_bias_sigma),
                          view.sensors.tuning.gyro_scale * z, gyro.lateness)};
}

/// a_y = v ψ̇, linear about (v_0, ψ̇_0). In a slide v̇_y is not small.
Row accel_y_row(const View& view) noexcept {
  constexpr double bank = 0.05;  // [g]
  const Averaged accel_y = view.average(Source::accel_y);
  const double demanded = view.v * view.r;
  const double turned =
      view.observed.usable(Source::yaw_rate)
          ? view.v * (view.average(Source::yaw_rate).mean - view.observed.errors.gyro_bias)
          : 0.0;
  const double sideways =
      accel_y.slides ? 0.5 * std::max({std::abs(demanded), std::abs(turned), sliding_accel}) : 0.0;
  const double sigma =
      root_of_squares(accel_y.noise, view.sensors.tuning.accel_bias, bank * gravity,
                      view.sensors.tuning.roll_gradient * view.side, accel_y.lateness, sideways,
                      view.average(Source::yaw_rate).changed * view.speed_changed);
  return {only(Source::accel_y), {view.r, view.v, 0.0, 0.0}, accel_y.mean + demanded, sigma};
}

}  // namespace

bool is_steady(const SourceHistory& gyro) noexcept {
  constexpr double swing = 0.02;  // [rad/s], plus two sigmas
  return std::abs(gyro.mean()) < largest_gyro_bias &&
         std::abs(gyro.mean() - gyro.mean(Over::long_time)) < swing + 2.0 * gyro.sigma;
}

double lateral_accel(const Observations& observed, Over over) noexcept {
  const double demanded = observed.speed(over) * observed.yaw_rate(over);
  const double measured =
      observed.usable(Source::accel_y) ? observed.history(Source::accel_y).mean(over) : demanded;
  return demanded * measured > 0.0 ? std::min(std::abs(demanded), std::abs(measured)) : 0.0;
}

Consensus equations(const Sensors& sensors, const Observations& observed, bool backwards,
                    Over over) noexcept {
  constexpr double slip_floor = 0.02;  // [m/s]
  constexpr double slip_share = 0.01;
  const View view{sensors, observed, over};
  const double v = view.v;
  Consensus all;
  const auto add = [&all](Sources sources, of::Index index, double z, double sigma) {
    all.add({sources, Motion::Unit(index), z, sigma});
  };
  // 1. Prior knowledge: how fast a car can change its motion, and how much wheels slip.
  const bool slid = observed.slid();
  // v̇_x = a_x + v_y ψ̇
  const double fastest = gravity + (slid ? std::abs(v * view.r) : 0.0);
  const double hold_s = 0.03 + seconds_of(over) - seconds_of(Over::short_time);
  add(0, of::speed, v,
      root_of_squares(observed.last_consensus.front().sigma[of::speed],
                      fastest * (hold_s + observed.speed_unknown_s)));
  add(0, of::yaw_rate, view.r, sensors.turn_in() * 3.0 * hold_s);
  // Driven wheels, or all wheels when braking, slip in proportion to the acceleration: the smaller
  // of the two from the accelerometer and from the wheels.
  double faster = 0.0;
  for (const Source wheel : wheel_sources) {
    const double rate = observed.history(wheel).rate(over);
    if (observed.usable(wheel) && std::abs(rate) > std::abs(faster)) {
      faster = rate;
    }
  }
  const double measured =
      observed.usable(Source::accel_x)
          ? std::abs(observed.history(Source::accel_x).mean(over) - observed.accel_offset)
          : std::abs(faster);
  const double accel = std::min(measured, std::abs(faster));
  const bool brakes = faster * v < 0.0;
  const auto slip = [&](Source wheel) {
    const bool driven = is_driven(sensors.car.driven, wheel);
    const bool slips = brakes || driven;
    return root_of_squares(slip_floor, (slid ? sensors.tuning.sliding_slip : slip_share) * v,
                           driven && observed.errors.speed_known ? observed.spin : 0.0,
                           slips ? observed.errors.wheel_slip * accel * v : 0.0);
  };
  add(0, of::front_slip, 0.0, slip(Source::wheel_front_left));
  add(0, of::rear_slip, 0.0, slip(Source::wheel_rear_left));

  // 2. The sources.
  const auto has_mean = [&](const SourceHistory& history) {
    return history.alive(observed.now_ns) &&
           (over == Over::short_time || history.duration_s() >= 2.0 * seconds_of(over));
  };
  const auto alive = [&](Source source) { return has_mean(observed.history(source)); };
  bool turning = false;
  bool standing = false;
  for (const Source wheel : wheel_sources) {
    if (alive(wheel)) {
      const bool turns = std::abs(observed.history(wheel).mean()) >= slowest_turning;
      turning |= observed.usable(wheel) && turns;
      standing |= observed.usable(wheel) && !turns;
      all.add(wheel_row(view, wheel, backwards));
    }
  }
  const bool stands = standing && !turning;
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
    add(only(Source::accel_x), of::speed, observed.integrated_speed, observed.integrated_sigma);
  }
  if (has_mean(observed.camera_speed)) {
    constexpr double share = 0.05;
    constexpr double floor = 0.03;  // [m/s, rad/s]
    // The noise of a mean rate is the position's noise / averaging time.
    const SourceHistory& speed = observed.camera_speed;
    const double seconds =
        std::min(std::max(camera_averaging_s, seconds_of(over)), speed.duration_s() + 1e-3);
    const double age_s = camera_averaging_s + seconds_between(speed.time_ns, observed.now_ns);
    const double noise =
        std::sqrt(observed.errors.camera_noise_scale * std::max(observed.camera_scatter, 1.0)) /
        seconds;
    const auto add_rate = [&](of::Index index, const SourceHistory& rate, double last) {
      add(only(Source::camera), index, rate.mean(over),
          root_of_squares(floor + share * std::abs(last), rate.sigma * noise,
                          age_s * rate.rate(over)));
    };
    add_rate(of::speed, speed, v);
    add_rate(of::yaw_rate, observed.camera_yaw_rate, view.r);
  }
  return all;
}

void learn_radii(const Consensus& all, const Solution& base, double dt,
                 Observations& observed) noexcept {
  constexpr double learnt_s = 20.0;
  constexpr double most = 0.02;
  const double v = base.motion[of::speed];
  if (std::abs(v) < min_learning_speed) {
    return;
  }
  for (const Source wheel : wheel_sources) {
    const Row* const row = std::ranges::find(all, only(wheel), &Row::sources);
    if (row == all.end()) {
      continue;
    }
    const double error = row->off(base.motion) * row->sigma / v;
    double& radius = observed.radius[index_of(wheel)];
    radius = std::clamp(radius + dt / learnt_s * error, -most, most);
  }
}

}  // namespace odomd::estimator::integrity
