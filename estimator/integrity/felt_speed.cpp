// docs/model.md, "Integrity".
#include "estimator/integrity/felt_speed.hpp"

#include <algorithm>
#include <cmath>

#include "estimator/common/squares.hpp"
#include "estimator/common/time.hpp"

namespace odomd::estimator::integrity {
namespace {

// The felt speed follows the others within so long [s].
constexpr double felt_s = 0.3;

}  // namespace

/// The speed goes on as the accelerometer says: v̇_x = a_x + v_y ψ̇, v_y = l_h ψ̇ - α_h v, and with
/// tyres that are linear α_h = m l_v a_y / (l C_h).
void feel(const Sensors& sensors, Heard& heard, double dt) noexcept {
  constexpr double slide = 0.5;  // v_y over v, of a car that slides
  constexpr double lately_s = 0.24;
  const Vehicle& car = sensors.car;
  const Witness& felt = heard.by(Source::accel_x);
  const double turn = heard.turn();
  const double side = side_push(heard, Over::short_time);
  const double softness =
      car.mass * car.front_axle / (car.wheelbase() * car.cornering_stiffness_rear);
  const double by_turn = car.rear_axle * turn * turn;
  const double by_tyres = std::copysign(softness * side * side, heard.speed());
  const double pull = felt.mean() - heard.felt_slope + by_turn - by_tyres;
  heard.felt_speed += pull * dt;
  const double sideways = heard.slides(heard.now_ns, lately_s) ? slide * heard.speed() * turn
                                                               : by_turn + std::abs(by_tyres);
  heard.felt_sigma +=
      dt * std::sqrt(squared(heard.felt_slope_sigma) + squared(felt.sigma) * felt.cycle_s / felt_s +
                     squared(sensors.tuning.pitch_gradient * pull) + squared(sideways));
}

/// Wheels that are locked brake a car, which is felt: one whose wheels were distrusted, that is not
/// seen to move, and that has felt nothing for so long, stands.
void rest_with_locked_wheels(Heard& heard) noexcept {
  constexpr double stands_after_s = 2.0;
  constexpr double slowest_turning = 0.02;  // [m/s]
  constexpr double brakes = 0.05;           // [g]
  constexpr double surely = 0.1;            // [m/s]
  bool rests = is_steady(heard.by(Source::yaw_rate)) &&
               std::abs(heard.by(Source::accel_x).mean(Over::long_time) - heard.felt_slope) <
                   brakes * gravity;
  for (std::size_t i = index_of(Source::wheel_front_left); i <= index_of(Source::motor); ++i) {
    const Witness& wheel = heard.sources[i];
    rests = rests && (!wheel.alive(heard.now_ns) || std::abs(wheel.mean()) < slowest_turning);
  }
  if (!rests || heard.seen_speed.alive(heard.now_ns)) {
    heard.rests_since_ns = heard.now_ns;
  } else if (seconds_between(heard.rests_since_ns, heard.now_ns) >= stands_after_s) {
    heard.felt_speed = 0.0;
    heard.felt_sigma = surely;
  }
}

/// As long as the accelerometer does not contradict the others, which know the speed, its own
/// follows theirs; how far it stays behind tells of slope and bias.
void follow(Heard& heard, double dt, const Others& others) noexcept {
  constexpr double slope_s = 20.0;
  constexpr double least_slope = 0.02;   // [g], by which it changes ...
  constexpr double most_slope = 0.06;    // ... and three times that is the steepest
  constexpr double contradicting = 2.5;  // sigmas
  constexpr double unknown = 10.0;       // [m/s]
  const double ahead = heard.felt_speed - heard.speed();
  const bool known = others.felt && heard.felt_sigma < unknown;
  if (!others.told ||
      (known && (others.contradicted || std::abs(ahead) > contradicting * heard.felt_sigma))) {
    return;
  }
  const double share = known ? -std::expm1(-dt / felt_s) : 1.0;
  heard.felt_speed -= share * ahead;
  heard.felt_sigma += share * (heard.speed_sigma - heard.felt_sigma);
  if (known && others.sound) {
    const double off = ahead / felt_s;
    heard.felt_for_s = std::min(heard.felt_for_s + dt, slope_s);
    const double follows = dt / heard.felt_for_s;
    constexpr double steepest = 3.0 * most_slope * gravity;
    heard.felt_slope = std::clamp(heard.felt_slope + follows * off, -steepest, steepest);
    if (std::abs(heard.speed()) < slowest_learning) {
      return;  // at rest no slope changes
    }
    const double variance = squared(heard.felt_slope_sigma);
    heard.felt_slope_sigma = std::clamp(std::sqrt(variance + follows * (off * off - variance)),
                                        least_slope * gravity, most_slope * gravity);
  }
}

}  // namespace odomd::estimator::integrity
