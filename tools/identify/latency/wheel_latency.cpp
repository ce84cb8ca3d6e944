// Latencies of wheel speeds.
#include <algorithm>
#include <cmath>

#include "tools/identify/common/car_model.hpp"
#include "tools/identify/latency/latency_estimate.hpp"

namespace odomd::tools {
namespace {

using estimator::Source;

// Errors of the model of an axle's wheels, as a standard uncertainty [s], from simulated cars.
constexpr double unmodelled_wheel = 0.3e-3;

// Effect of the delayed load transfer on the slip of the outer wheels [s], per metre of wheelbase
// and g of lateral acceleration (rms). From simulated cars of 0.26 and 2.7 m.
constexpr double unmodelled_load = 15e-3;

Resampled mean_of(const Resampled& left, const Resampled& right) {
  return combined(left, right, [](double a, double b) { return 0.5 * (a + b); });
}

// The speed along x, from the speed V along the front wheels. In a turn the gyro and the tyres give
// the slip angle α of the front axle, and the angle β of its motion to x,
//   α = m l_h v ψ̇ / (l C_v),  β = l ψ̇ / v - m l_v v ψ̇ / (l C_h),  δ = α + β,
//   V = v_x (cos δ + sin δ tan β)
Resampled straightened(const Resampled& along, const GyroDrive& drive) {
  const estimator::Vehicle& car = drive.config.vehicle;
  return combined(along, drive.yaw_rate, [&car](double v, double yaw_rate) {
    if (std::fabs(v) < 0.2) return v;
    const double side = car.mass * v * yaw_rate / car.wheelbase();
    const double slip = side * car.rear_axle / car.cornering_stiffness_front;
    const double direction = std::clamp(
        car.wheelbase() * yaw_rate / v - side * car.front_axle / car.cornering_stiffness_rear, -1.0,
        1.0);
    const double delta = slip + direction;
    return v / (std::cos(delta) + std::sin(delta) * std::tan(direction));
  });
}

// Speed along a wheel at y_i, steered by δ_i:
//   V_i = (v_x - y_i ψ̇) cos δ_i + (v_y + l_v ψ̇) sin δ_i,  tan δ_i = l tan δ / (l - y_i tan δ)
// so V_right - V_left = t ψ̇ cos δ, plus a small part from the wheels' different directions.
struct Difference {
  Resampled turn;
  Resampled ackermann;
};

Difference front_difference(const estimator::Vehicle& car, const Resampled& turning,
                            const Resampled& along, const FrontWheels& wheels) {
  Difference result{turning, turning};
  for (std::size_t i = 0; i < turning.value.size(); ++i) {
    const double t = turning.begin + turning.step * static_cast<double>(i);
    const double yaw_rate = turning.value[i];
    const double delta = wheels.angle.at(t);
    const double side = wheels.side_speed.at(t) + car.front_axle * yaw_rate;
    const double v_x = (along.at(t) - side * std::sin(delta)) / std::cos(delta);
    const auto of_wheel = [&](double y) {
      const double own =
          std::atan2(car.wheelbase() * std::tan(delta), car.wheelbase() - y * std::tan(delta));
      return (v_x - y * yaw_rate) * std::cos(own) + side * std::sin(own);
    };
    const double half = 0.5 * car.track_width;
    result.turn.value[i] = car.track_width * yaw_rate * std::cos(delta);
    result.ackermann.value[i] = of_wheel(-half) - of_wheel(half) - result.turn.value[i];
  }
  return result;
}

struct Turning {
  Resampled yaw_rate;        // smoothed
  double slope_noise = 0.0;  // variance of the noise in its slope
};

// Averages the yaw rate over longer and longer windows until the noise in its derivative is a tenth
// of the motion, at most over the longest window that still resolves turns.
Turning turning_above_noise(const GyroDrive& drive, double shortest) {
  const double cycle = 0.5 * two_cycles(drive.log.of(Source::yaw_rate));
  const double white = std::pow(white_sigma(drive.log.of(Source::yaw_rate).value), 2);
  constexpr double enough = 0.1, longest = 0.25;
  double half = shortest;
  while (true) {
    // Two means over ± h have a triangle as weight; its slope is ± 1/(4 h²) over a length of 4 h.
    Turning turning{smooth(drive.yaw_rate, half), white * cycle / (4.0 * std::pow(half, 3))};
    double slopes = 0.0;
    const std::vector<double>& value = turning.yaw_rate.value;
    for (std::size_t i = 1; i < value.size(); ++i)
      slopes += std::pow((value[i] - value[i - 1]) / turning.yaw_rate.step, 2) /
                static_cast<double>(value.size());
    if (turning.slope_noise < enough * slopes || 2.0 * half > longest) return turning;
    half *= 2.0;
  }
}

// A wheel's spin lags the ground by I v / (r² C_κ): I / r² is about 0.7 of the wheel's mass, or 1 %
// of the car's; a geared motor at the rear adds the same; a wheel's C_κ is about twice its C_α. All
// within a factor of two.
constexpr double front_spin = 0.0105, rear_spin = 2.0 * front_spin;  // lag · C / (m v)
constexpr double spin_lag_sigma = 0.5;                               // relative

}  // namespace

// v_right - v_left. A driven or braked axle slips by κ, and its inner wheel, which carries less,
// slips more: this adds κ t ψ̇ and v κ Δ(1/C_κ), with κ = m v̇ / 2 C_κ, and ΔC_κ ~ a_y = v ψ̇ from
// the load exponent of a tyre (0.8) and a centre of gravity about a quarter of the track high.
SourceOffset wheel_pair(const GyroDrive& drive, Source left, Source right,
                        const std::optional<FrontWheels>& front_wheels) {
  const Series& l = drive.log.of(left);
  const Series& r = drive.log.of(right);
  OffsetRegression regression;
  const Resampled right_side = drive.on_grid(r);
  const Resampled left_side = drive.on_grid(l);
  constexpr double creeping = 0.3;  // s
  double moved = -creeping;
  const auto moves = [&](std::size_t i) {
    return l.value[i] != 0.0 || right_side.at(drive.log.seconds(l.t_ns[i])) != 0.0;
  };
  for (std::size_t i = 0, ahead = 0; i < l.size(); ++i) {
    const double t = drive.log.seconds(l.t_ns[i]);
    for (; ahead < l.size() && drive.log.seconds(l.t_ns[ahead]) <= t + creeping; ++ahead)
      if (moves(ahead)) moved = drive.log.seconds(l.t_ns[ahead]);
    if (t < drive.begin + regression.range || t > drive.end - regression.range) continue;
    // At standstill there is neither noise nor information on time. A creeping wheel also reads 0
    // between two counts.
    if (t > moved + creeping) continue;
    regression.t.push_back(t);
    regression.y.push_back(right_side.at(t) - l.value[i]);
  }
  const estimator::Vehicle& car = drive.config.vehicle;
  const bool front = estimator::is_front(left);
  const double stiffness = front ? car.cornering_stiffness_front : car.cornering_stiffness_rear;
  const Resampled speed = mean_of(left_side, right_side);
  // A wheel's speed is a mean over its cycle. The gyro's interpolated noise is smaller between two
  // samples than at a sample: without averaging, the offset would be biased to the middle between
  // them. Quieter turns need a longer mean.
  const Turning turn = turning_above_noise(
      drive, std::max(0.5 * two_cycles(drive.log.of(Source::yaw_rate)), 0.25 * two_cycles(l)));
  const Resampled& turning = turn.yaw_rate;
  regression.slope_noise = car.track_width * car.track_width * turn.slope_noise;
  Difference difference{turning, {}};
  for (double& value : difference.turn.value) value *= car.track_width;
  if (front && front_wheels) difference = front_difference(car, turning, speed, *front_wheels);

  // The lag is set to its expected value; its uncertainty adds to the offset's uncertainty.
  const Resampled lagging = combined(slope_around(difference.turn, 0.02), speed,
                                     [](double rate, double v) { return rate * std::fabs(v); });
  const auto with_lag = [&](double seconds_per_speed) {
    const Resampled late = combined(difference.turn, lagging, [&](double own, double lag) {
      return own - seconds_per_speed * lag;
    });
    const Resampled force = times(turning, slope_around(speed, 0.05));
    const double slip = car.mass / (4.0 * stiffness);
    const double shift = 0.06 * slip;
    regression.basis = {{late, 1.0, 0.1},
                        {constant(speed)},  // the gyro's bias
                        {speed, 0.0, 0.02},
                        {force, 0.0, 2.0 * car.track_width * slip},
                        {times(force, times(speed, speed)), 0.0, 2.0 * shift}};
    if (!difference.ackermann.value.empty())
      regression.basis.push_back({difference.ackermann, 1.0, 0.5});
    return solve(regression);
  };
  const Offset found = with_lag((front ? front_spin : rear_spin) * car.mass / stiffness);
  const Offset without = with_lag(0.0);
  SourceOffset result = as_offset(left, "the gyro, by the difference of both wheels", found);
  if (result.failure.empty() && found.coefficients[0] < 0.0)
    result.failure = "turns the other way than the gyro: are left and right exchanged?";
  const double of_lag = spin_lag_sigma * (found.value - without.value);
  double accel = 0.0;  // a_y² = (v ψ̇)², mean
  for (const double t : regression.t)
    accel += std::pow(speed.at(t) * turning.at(t), 2) / static_cast<double>(regression.t.size());
  const double of_load = unmodelled_load * car.wheelbase() * std::sqrt(accel) / car_model::gravity;
  result.sigma = std::hypot(result.sigma, std::hypot(unmodelled_wheel, of_load), of_lag);
  return result;
}

// The displacement along the heading over τ, as the camera sees it, is ∫ v over τ. The chord of an
// arc is shorter by Δψ²/24, and a reference point off the centre of gravity adds its distance
// times Δψ.
SourceOffset speed_by_camera(const GyroDrive& drive, Source source,
                             std::span<const estimator::CameraPose> camera, double camera_offset) {
  OffsetRegression r;
  constexpr double tau = 0.2;
  const auto over_tau = [](const Resampled& signal) {
    return on_grid_of(
        signal, [&](double t) { return signal.at(t + 0.5 * tau) - signal.at(t - 0.5 * tau); });
  };
  const Resampled distance = over_tau(integral(drive.on_grid(drive.log.of(source))));
  const Resampled turn = over_tau(drive.turned);
  const std::vector<PoseSample> seen = in_order(camera, drive.log.first_ns);
  for (std::size_t i = 0, j = 0; i < seen.size(); ++i) {
    while (j + 1 < seen.size() && seen[j + 1].t - seen[i].t <= tau + 1e-3) ++j;
    const double span = seen[j].t - seen[i].t, t = 0.5 * (seen[i].t + seen[j].t);
    if (std::fabs(span - tau) > 0.3 * tau) continue;
    if (t < drive.begin + r.range || t > drive.end - r.range) continue;
    if (!r.t.empty() && t <= r.t.back()) continue;
    const double turned = turn.at(t - camera_offset);
    const double middle = 0.5 * (seen[i].yaw + seen[j].yaw) - drive.config.camera.lever_arm[2];
    const double along =
        (seen[j].x - seen[i].x) * std::cos(middle) + (seen[j].y - seen[i].y) * std::sin(middle);
    r.t.push_back(t);
    r.y.push_back(along * tau / span * (1.0 + turned * turned / 24.0));
  }
  r.basis = {{distance, 1.0, 0.1}, {turn, 0.0, 0.5 * drive.config.vehicle.wheelbase()}};
  Offset found = solve(r);
  // The camera was shifted, not the source: reverse the sign, and refer the offset to the gyro.
  found.value = camera_offset - found.value;
  return as_offset(source, "the camera's way", found);
}

std::optional<Resampled> best_speed(const GyroDrive& drive,
                                    const std::vector<SourceOffset>& offsets) {
  const auto has = [&](Source source) { return drive.log.has(source); };
  const auto on_grid = [&](Source source) { return drive.on_grid(drive.log.of(source)); };
  Source source{};
  std::optional<Resampled> speed;
  for (const auto& [left, right] : estimator::wheel_pairs) {  // the undriven front wheels first
    if (speed || !has(left) || !has(right)) continue;
    source = left;
    speed = mean_of(on_grid(left), on_grid(right));
    if (estimator::is_front(left)) speed = straightened(*speed, drive);
  }
  for (const Source single :
       {Source::wheel_rear, Source::motor, Source::wheel_rear_left, Source::wheel_rear_right}) {
    if (speed || !has(single)) continue;
    source = single;
    speed = on_grid(single);
  }
  const auto found = std::ranges::find_if(offsets, [source](const SourceOffset& offset) {
    return offset.source == source && offset.failure.empty();
  });
  if (speed && found != offsets.end()) speed->begin -= found->offset;
  return speed;
}

}  // namespace odomd::tools
