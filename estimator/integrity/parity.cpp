// docs/model.md, "Parities".
#include "estimator/integrity/parity.hpp"

#include <algorithm>
#include <cmath>
#include <initializer_list>
#include <utility>

#include "estimator/common/squares.hpp"
#include "estimator/common/wheel_place.hpp"

namespace odomd::estimator::integrity {
namespace {

// Two sensors are heard so far apart, beside half of a cycle [s]; and a servo is behind what it is
// told by so much more.
constexpr double apart_s = 0.01;
constexpr double servo_s = 0.05;
// A camera's motion is a mean over some time [s].
constexpr double seen_s = 0.15;

/// What is known of the sensors and the car, what was heard, and over how long it is averaged.
struct View {
  const Sensors& sensors;
  const Heard& heard;
  Over over;

  [[nodiscard]] double speed() const noexcept { return heard.speed(over); }
  [[nodiscard]] double turn() const noexcept { return heard.turn(over); }
  [[nodiscard]] double mean(Source source) const noexcept { return heard.by(source).mean(over); }
  [[nodiscard]] double side() const noexcept { return side_push(heard, over); }
  [[nodiscard]] bool slides(Source source) const noexcept {
    return heard.slides(heard.by(source).time_ns, 4.0 * seconds_of(over));
  }
  /// What a mean may be off by for its age alone: no car changes its speed at more than 1.5 g.
  [[nodiscard]] double late(Source source) const noexcept {
    const Witness& witness = heard.by(source);
    const double most = is_wheel(source) ? 1.5 * gravity : 1e9;
    return (witness.cycle_s + apart_s) * std::min(std::abs(witness.rate(over)), most);
  }
  /// The mean of a product is not that of the means.
  [[nodiscard]] double speed_changed() const noexcept {
    return over == Over::long_time ? heard.speed() - heard.speed(over) : 0.0;
  }
  [[nodiscard]] double changed(Source source) const noexcept {
    const Witness& witness = heard.by(source);
    return witness.mean() - witness.mean(over);
  }
  [[nodiscard]] double noise(Source source) const noexcept { return heard.by(source).noise(over); }
};

/// The speed of a wheel's place along the wheel, at (v_0, ψ̇_0): f = ± |(v - y ψ̇, x ψ̇)|.
Row wheel_row(const View& view, Source source, bool backwards) noexcept {
  const WheelPlace place = wheel_place(view.sensors.car, source);
  const double v = view.speed();
  const double r = view.turn();
  // A front wheel moves sideways with l ψ̇, behind an axle that does not slip.
  const double l = place.steered ? view.sensors.car.wheelbase() : 0.0;
  const double along = v - place.left * r;
  const double across = l * r;
  const double f = std::copysign(std::hypot(along, across), along);
  Row row{.sources = only(source)};
  const bool still = std::abs(f) < 1e-3;
  row.by[of::speed] = still ? 1.0 : along / f;
  row.by[of::turn] = still ? -place.left : (l * across - place.left * along) / f;
  row.by[place.steered ? of::front_slip : of::rear_slip] = 1.0;
  // Wheels differ in radius; and the outer ones, which carry more, roll on a smaller one.
  const double outer = -std::copysign(place.left == 0.0 ? 0.0 : 1.0, place.left) * v * r / gravity;
  const double mean =
      view.mean(source) / (1.0 + view.heard.radius[index_of(source)] + view.heard.load * outer);
  row.z = (backwards ? -mean : mean) - f + row.by[of::speed] * v + row.by[of::turn] * r;
  row.sigma = root_of_squares(view.noise(source), 0.25 * view.heard.by(source).sigma,
                              view.sensors.tuning.wheel_radius * f,
                              view.heard.load_sigma * view.side() / gravity * f, view.late(source));
  return row;
}

/// ψ̇ = v tan δ / (l + K v²), K the understeer gradient.
Row steering_row(const View& view) noexcept {
  constexpr double share = 0.1;        // of the turn: play, links, a tyre's radius
  constexpr double least_off = 0.005;  // [rad]
  constexpr double slowest = 0.5;      // [m/s]
  const Vehicle& car = view.sensors.car;
  // From here on the front may slide [m/s²]; a driver who loses the car does not hold still.
  const double sliding = view.heard.by(Source::steering).repeats() ? 5.0 : 2.5;
  const double l = car.wheelbase();
  const double gradient = car.mass *
                          (car.rear_axle * car.cornering_stiffness_rear -
                           car.front_axle * car.cornering_stiffness_front) /
                          (l * car.cornering_stiffness_front * car.cornering_stiffness_rear);
  const double v = view.speed();
  const Known& known = view.heard.known;
  const double tangent =
      std::tan(std::clamp(view.mean(Source::steering) - known.steering_offset, -1.4, 1.4));
  const double most = v * tangent / std::max(0.5 * l, l + std::min(gradient, 0.0) * v * v);
  const double least = std::abs(v * most) > sliding
                           ? 0.0
                           : v * tangent / (l + 1.5 * std::max(gradient, 0.0) * v * v);
  Row row{.sources = only(Source::steering)};
  row.by[of::turn] = 1.0;
  // Held against the speed too: ∂ψ̇/∂v of a car without understeer.
  row.by[of::speed] = -tangent / l;
  row.z = 0.5 * (most + least) - tangent / l * v;
  const double by_v = (1.0 + tangent * tangent) / l;
  const double by_delta = std::abs(v) * by_v;
  // A car answers its steering so much later: ψ̈ = -ψ̇ (l_v² C_v + l_h² C_h) / (J_z v) + ...
  const double answers_s = car.yaw_inertia * std::abs(v) /
                           (car.front_axle * car.front_axle * car.cornering_stiffness_front +
                            car.rear_axle * car.rear_axle * car.cornering_stiffness_rear);
  // Who slides steers as he must, against the turn even.
  const double counter =
      view.slides(Source::steering)
          ? std::max(std::abs(view.turn()), limit / std::max(std::abs(view.speed()), slowest))
          : 0.0;
  const double late =
      view.late(Source::steering) +
      (servo_s + answers_s) * std::abs(view.heard.by(Source::steering).rate(view.over));
  const double offset = std::max(least_off, known.steering_offset_sigma);
  row.sigma = root_of_squares(by_delta * view.noise(Source::steering), by_delta * offset,
                              by_delta * late, share * most, 0.5 * (most - least), counter, 0.02,
                              by_v * view.changed(Source::steering) * view.speed_changed());
  return row;
}

Row gyro_row(const View& view) noexcept {
  constexpr double least_off = 0.01;  // [rad/s]
  const Known& known = view.heard.known;
  Row row{.sources = only(Source::yaw_rate)};
  row.by[of::turn] = 1.0;
  row.z = view.mean(Source::yaw_rate) - known.gyro_bias;
  row.sigma =
      root_of_squares(view.noise(Source::yaw_rate), std::max(least_off, known.gyro_bias_sigma),
                      view.sensors.tuning.gyro_scale * row.z, view.late(Source::yaw_rate));
  return row;
}

/// a_y = v ψ̇, at (v_0, ψ̇_0): a car that slides moves sideways ever faster.
Row felt_row(const View& view) noexcept {
  constexpr double sideways = 0.05;  // [g]: banks, and what is felt beside it
  const double felt = view.mean(Source::accel_y);
  const double demanded = std::abs(view.speed() * view.turn());
  Row row{.sources = only(Source::accel_y)};
  row.by[of::speed] = view.turn();
  row.by[of::turn] = view.speed();
  row.z = felt + view.speed() * view.turn();
  row.sigma = root_of_squares(view.noise(Source::accel_y), view.sensors.tuning.accel_bias,
                              sideways * gravity, view.sensors.tuning.roll_gradient * view.side(),
                              view.late(Source::accel_y),
                              view.slides(Source::accel_y) ? 0.5 * std::max(demanded, limit) : 0.0,
                              view.changed(Source::yaw_rate) * view.speed_changed());
  return row;
}

}  // namespace

bool is_steady(const Witness& gyro) noexcept {
  constexpr double swing = 0.02;  // [rad/s], and two sigmas
  return std::abs(gyro.mean()) < largest_gyro_bias &&
         std::abs(gyro.mean() - gyro.mean(Over::long_time)) < swing + 2.0 * gyro.sigma;
}

double side_push(const Heard& heard, Over over) noexcept {
  const double demanded = heard.speed(over) * heard.turn(over);
  const double push =
      heard.tells(Source::accel_y) ? heard.by(Source::accel_y).mean(over) : demanded;
  return demanded * push > 0.0 ? std::min(std::abs(demanded), std::abs(push)) : 0.0;
}

Consensus parities(const Sensors& sensors, const Heard& heard, bool backwards, Over over) noexcept {
  constexpr double slip_floor = 0.02;  // [m/s]
  constexpr double slip_share = 0.01;
  constexpr double slowest_turning = 0.02;  // [m/s]
  const View view{sensors, heard, over};
  Consensus all;
  const auto add = [&all](Sources sources, std::initializer_list<std::pair<of::Index, double>> by,
                          double z, double sigma) {
    Row row{.sources = sources, .z = z, .sigma = sigma};
    for (const auto& [index, value] : by) {
      row.by[index] = value;
    }
    all.add(row);
  };
  // 1. What is known beforehand: no car changes its motion faster; wheels slip a little.
  const double hold_s = 0.03 + seconds_of(over) - seconds_of(Over::short_time);
  const double v = view.speed();
  add(0, {{of::speed, 1.0}}, v,
      root_of_squares(heard.speed_sigma, gravity * (hold_s + heard.untold_s)));
  add(0, {{of::turn, 1.0}}, view.turn(),
      sensors.tuning.turn_in * gravity / sensors.car.wheelbase() * 3.0 * hold_s);
  // Wheels that drive slip, and all that brake; by what is felt, or by what they do where that is
  // less.
  double faster = 0.0;
  for (std::size_t i = index_of(Source::wheel_front_left); i <= index_of(Source::motor); ++i) {
    const double rate = heard.sources[i].rate(over);
    if (heard.tells(static_cast<Source>(i)) && std::abs(rate) > std::abs(faster)) {
      faster = rate;
    }
  }
  const double felt = heard.tells(Source::accel_x)
                          ? std::abs(view.mean(Source::accel_x) - heard.felt_slope)
                          : std::abs(faster);
  const double pull = std::min(felt, std::abs(faster));
  const bool brakes = faster * v < 0.0;
  const auto slip = [&](Source wheel) {
    const bool slips = brakes || is_driven(sensors.car.driven, wheel);
    return root_of_squares(slip_floor, slip_share * v,
                           slips ? heard.known.wheel_slip * pull * v : 0.0);
  };
  add(0, {{of::front_slip, 1.0}}, 0.0, slip(Source::wheel_front_left));
  add(0, {{of::rear_slip, 1.0}}, 0.0, slip(Source::wheel_rear_left));

  // 2. The sources.
  const auto tells = [&](const Witness& witness) {
    return witness.alive(heard.now_ns) &&
           (over == Over::short_time || witness.heard_s() >= 2.0 * seconds_of(over));
  };
  const auto alive = [&](Source source) { return tells(heard.by(source)); };
  int turning = 0;
  int resting = 0;
  for (std::size_t i = index_of(Source::wheel_front_left); i <= index_of(Source::motor); ++i) {
    if (alive(static_cast<Source>(i))) {
      if (heard.tells(static_cast<Source>(i))) {
        ++(std::abs(heard.sources[i].mean()) < slowest_turning ? resting : turning);
      }
      all.add(wheel_row(view, static_cast<Source>(i), backwards));
    }
  }
  const bool rests = resting > 0 && turning == 0;
  if (alive(Source::yaw_rate) && !(rests && is_steady(heard.by(Source::yaw_rate)))) {
    all.add(gyro_row(view));
  }
  if (alive(Source::steering)) {
    all.add(steering_row(view));
  }
  if (alive(Source::accel_y)) {
    all.add(felt_row(view));
  }
  if (alive(Source::accel_x) && over == Over::short_time) {
    add(only(Source::accel_x), {{of::speed, 1.0}}, heard.felt_speed, heard.felt_sigma);
  }
  if (tells(heard.seen_speed)) {
    constexpr double share = 0.05;
    const Witness& speed = heard.seen_speed;
    const Witness& turn = heard.seen_turn;
    // The mean of a rate is what the place has changed by.
    const double seconds = std::min(std::max(seen_s, seconds_of(over)), speed.heard_s() + 1e-3);
    const double age_s = seen_s + seconds_between(speed.time_ns, heard.now_ns);
    const double noise = std::sqrt(heard.known.camera_unrest) / seconds;
    add(only(Source::camera), {{of::speed, 1.0}}, speed.mean(over),
        root_of_squares(0.03 + share * std::abs(v), speed.sigma * noise, age_s * speed.rate(over)));
    add(only(Source::camera), {{of::turn, 1.0}}, turn.mean(over),
        root_of_squares(0.03 + share * std::abs(view.turn()), turn.sigma * noise,
                        age_s * turn.rate(over)));
  }
  return all;
}

}  // namespace odomd::estimator::integrity
