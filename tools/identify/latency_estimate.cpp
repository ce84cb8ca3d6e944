#include "tools/identify/latency_estimate.hpp"

#include <algorithm>
#include <cmath>
#include <stdexcept>
#include <utility>

#include "tools/identify/offset_regression.hpp"
#include "tools/identify/response_fit.hpp"
#include "tools/text.hpp"

namespace odomd::tools {
namespace {

using estimator::Source;

struct Drive {
  const daemon::Config& config;
  const SignalLog& log;
  double begin = 0.0;
  double end = 0.0;
  Resampled yaw_rate;
  Resampled turned;  // its integral

  [[nodiscard]] double seconds(std::int64_t t_ns) const {
    return 1e-9 * static_cast<double>(t_ns - log.first_ns);
  }
  [[nodiscard]] Resampled on_grid(const Series& series) const {
    return resampled(series, log.first_ns, begin, end);
  }
  /// Two cycles of a signal, within bounds: what derivatives are taken over.
  [[nodiscard]] static double two_cycles(const Series& series) {
    const double span = 1e-9 * static_cast<double>(series.t_ns.back() - series.t_ns.front());
    return std::clamp(2.0 * span / static_cast<double>(std::max<std::size_t>(series.size(), 2) - 1),
                      0.01, 0.2);
  }
};

Resampled shifted(Resampled signal, double later) {
  signal.begin += later;
  return signal;
}

Resampled times(const Resampled& a, const Resampled& b) {
  return combined(a, b, [](double u, double v) { return u * v; });
}

Resampled constant(const Resampled& like) {
  Resampled one = like;
  std::ranges::fill(one.value, 1.0);
  return one;
}

double top_of(const Resampled& signal) {
  double most = 0.0;
  for (const double value : signal.value) most = std::max(most, std::fabs(value));
  return most;
}

// What the models below leave out, as standard uncertainties [s], seen on simulated cars that have
// it: of wheels, that their spin follows the ground by inertia and slip, and that load moves; of
// the side force, that tyres bend.
constexpr double unmodelled_wheel = 0.75e-3;
constexpr double unmodelled_side_force = 5e-3;

SourceOffset as_offset(Source source, std::string against, const Offset& found) {
  return {source, std::move(against), found.value, found.sigma, found.explained, found.doubt};
}

// ψ_camera(t) = (1 + s) ∫ gyro(t - D) + b t + c
SourceOffset camera_yaw(const Drive& drive, std::span<const estimator::CameraPose> camera) {
  OffsetRegression r;
  std::vector<std::pair<std::int64_t, double>> seen;
  for (const estimator::CameraPose& pose : camera) seen.emplace_back(pose.capture_ns, pose.yaw);
  std::ranges::sort(seen);
  double yaw = seen.empty() ? 0.0 : seen.front().second;
  for (const auto& [t_ns, raw] : seen) {
    const double t = drive.seconds(t_ns);
    yaw += std::remainder(raw - yaw, 2.0 * M_PI);
    if (t < drive.begin + r.range || t > drive.end - r.range) continue;
    if (!r.t.empty() && t <= r.t.back()) continue;
    r.t.push_back(t);
    r.y.push_back(yaw);
  }
  Resampled clock = drive.turned;
  for (std::size_t i = 0; i < clock.value.size(); ++i)
    clock.value[i] = clock.step * static_cast<double>(i);
  // The gyro's bias and its walk: knots every ten seconds.
  r.basis = {{drive.turned, 1.0, 0.1}, {constant(clock)}, {clock}};
  const double span = drive.end - drive.begin;
  const int knots = static_cast<int>(std::clamp(std::floor(span / 15.0) - 1.0, 0.0, 40.0));
  for (int k = 1; k <= knots; ++k) {
    Resampled bend = clock;
    const double from = span * k / (knots + 1);
    for (double& value : bend.value) value = std::max(0.0, value - from);
    r.basis.push_back({std::move(bend), 0.0, 5e-3});
  }
  const Offset found = solve(r);
  SourceOffset result = as_offset(Source::camera, "the gyro's turn", found);
  // What an angle explains of itself says little: demand that it turns enough.
  if (result.doubt.empty()) {
    if (top_of(drive.yaw_rate) < 0.02) result.doubt = "the car does not turn";
  }
  return result;
}

// v_right - v_left = t ψ̇ (front: t ψ̇ cos δ) + radii that differ + slip that differs
SourceOffset wheel_pair(const Drive& drive, Source left, Source right) {
  const Series& l = drive.log.of(left);
  const Series& r = drive.log.of(right);
  OffsetRegression regression;
  const Resampled right_side = drive.on_grid(r);
  const Resampled left_side = drive.on_grid(l);
  for (std::size_t i = 0; i < l.size(); ++i) {
    const double t = drive.seconds(l.t_ns[i]);
    if (t < drive.begin + regression.range || t > drive.end - regression.range) continue;
    regression.t.push_back(t);
    regression.y.push_back(right_side.at(t) - l.value[i]);
  }
  const Resampled speed =
      combined(left_side, right_side, [](double a, double b) { return 0.5 * (a + b); });
  const Resampled accel = slope_around(speed, 0.05);
  const double track = drive.config.vehicle.track_width;
  // What an axle drives or brakes with, its inner wheel, which carries less, slips more.
  const Resampled slip = times(times(drive.yaw_rate, accel), times(speed, speed));
  regression.basis = {{drive.yaw_rate, track, 0.1 * track}, {speed, 0.0, 0.02}, {slip}};
  SourceOffset result =
      as_offset(left, "the gyro, by the difference of both wheels", solve(regression));
  result.sigma = std::hypot(result.sigma, unmodelled_wheel);
  return result;
}

// The displacement over τ along the heading, seen by the camera: ∫ v over τ; the chord of an arc is
// shorter by Δψ²/24, and a reference point beside the centre of gravity adds its lever times Δψ.
SourceOffset speed_by_camera(const Drive& drive, Source source,
                             std::span<const estimator::CameraPose> camera, double camera_offset) {
  const Series& series = drive.log.of(source);
  OffsetRegression r;
  constexpr double tau = 0.2;
  Resampled travelled = integral(drive.on_grid(series));
  Resampled way = travelled;
  for (std::size_t i = 0; i < way.value.size(); ++i) {
    const double t = way.begin + way.step * static_cast<double>(i);
    way.value[i] = travelled.at(t + 0.5 * tau) - travelled.at(t - 0.5 * tau);
  }
  Resampled turn = drive.turned;
  for (std::size_t i = 0; i < turn.value.size(); ++i) {
    const double t = turn.begin + turn.step * static_cast<double>(i);
    turn.value[i] = drive.turned.at(t + 0.5 * tau) - drive.turned.at(t - 0.5 * tau);
  }
  std::vector<const estimator::CameraPose*> seen;
  for (const estimator::CameraPose& pose : camera) seen.push_back(&pose);
  std::ranges::sort(seen, {}, &estimator::CameraPose::capture_ns);
  const double mounted = drive.config.camera.lever_arm[2];
  for (std::size_t i = 0, j = 0; i < seen.size(); ++i) {
    while (j + 1 < seen.size() && drive.seconds(seen[j + 1]->capture_ns - seen[i]->capture_ns +
                                                drive.log.first_ns) <= tau + 1e-3)
      ++j;
    const double span = 1e-9 * static_cast<double>(seen[j]->capture_ns - seen[i]->capture_ns);
    const double t =
        0.5 * (drive.seconds(seen[i]->capture_ns) + drive.seconds(seen[j]->capture_ns));
    if (std::fabs(span - tau) > 0.3 * tau) continue;
    if (t < drive.begin + r.range || t > drive.end - r.range) continue;
    if (!r.t.empty() && t <= r.t.back()) continue;
    const double turned = turn.at(t - camera_offset);
    const double middle =
        seen[i]->yaw + 0.5 * std::remainder(seen[j]->yaw - seen[i]->yaw, 2.0 * M_PI) - mounted;
    const double along =
        (seen[j]->x - seen[i]->x) * std::cos(middle) + (seen[j]->y - seen[i]->y) * std::sin(middle);
    r.t.push_back(t);
    r.y.push_back(along * tau / span * (1.0 + turned * turned / 24.0));
  }
  r.basis = {{way, 1.0, 0.1}, {turn, 0.0, 0.5 * drive.config.vehicle.wheelbase()}};
  Offset found = solve(r);
  // The camera was the one that moved: turned round, and from the camera to the gyro.
  found.value = camera_offset - found.value;
  return as_offset(source, "the camera's way", found);
}

// How the front axle moves in a turn, by the gyro and the tyres: slip angle α and, of the axle's
// motion, the angle to x,
//   α = m l_h v ψ̇ / (l C_v),  β = l ψ̇ / v - m l_v v ψ̇ / (l C_h),  δ = α + β
struct FrontAxle {
  double slip = 0.0;
  double direction = 0.0;
};
FrontAxle front_axle(const estimator::Vehicle& car, double v, double yaw_rate) {
  if (std::fabs(v) < 0.2) return {};
  const double side = car.mass * v * yaw_rate / car.wheelbase();
  return {.slip = side * car.rear_axle / car.cornering_stiffness_front,
          .direction = std::clamp(
              car.wheelbase() * yaw_rate / v - side * car.front_axle / car.cornering_stiffness_rear,
              -1.0, 1.0)};
}

// v_x from the speed along the front wheels: V = v_x (cos δ + sin δ tan β).
Resampled straightened(const Resampled& along, const Drive& drive) {
  return combined(along, drive.yaw_rate, [&](double v, double yaw_rate) {
    const FrontAxle axle = front_axle(drive.config.vehicle, v, yaw_rate);
    const double delta = axle.slip + axle.direction;
    return v / (std::cos(delta) + std::sin(delta) * std::tan(axle.direction));
  });
}

// The speed of the centre of gravity along x, the wheels that are not driven first.
struct Speed {
  Resampled value;  ///< on the gyro's clock
  Source source = Source::wheel_rear;
  bool driven = true;
  double offset_sigma = 0.0;
};

std::optional<Speed> best_speed(const Drive& drive, const std::vector<SourceOffset>& offsets) {
  const auto offset_of = [&](Source source) -> std::pair<double, double> {
    for (const SourceOffset& found : offsets)
      if (found.source == source && found.doubt.empty()) return {found.offset, found.sigma};
    return {0.0, 0.0};
  };
  const auto mapped = [&](Source source) { return drive.log.of(source).size() > 1; };
  const auto mean_of = [&](Source left, Source right) {
    return combined(drive.on_grid(drive.log.of(left)), drive.on_grid(drive.log.of(right)),
                    [](double a, double b) { return 0.5 * (a + b); });
  };
  std::optional<Speed> result;
  if (mapped(Source::wheel_front_left) && mapped(Source::wheel_front_right)) {
    const Resampled along =
        straightened(mean_of(Source::wheel_front_left, Source::wheel_front_right), drive);
    result = {along, Source::wheel_front_left, false, 0.0};
  } else if (mapped(Source::wheel_rear_left) && mapped(Source::wheel_rear_right)) {
    result = {mean_of(Source::wheel_rear_left, Source::wheel_rear_right), Source::wheel_rear_left,
              true, 0.0};
  } else {
    for (const Source source :
         {Source::wheel_rear, Source::motor, Source::wheel_rear_left, Source::wheel_rear_right}) {
      if (result || !mapped(source)) continue;
      result = {drive.on_grid(drive.log.of(source)), source, true, 0.0};
    }
  }
  if (!result) return result;
  const auto [offset, sigma] = offset_of(result->source);
  result->value = shifted(result->value, -offset);
  result->offset_sigma = sigma;
  return result;
}

// Twice the mean over ± half: of an acceleration and of what it is laid over alike, so that neither
// is late, and that the gyro's noise, differentiated, stays below what is differentiated.
Resampled smooth(const Resampled& signal, double half) {
  return mean_around(integral(mean_around(integral(signal), half)), half);
}

double smoothing(const Series& series) {
  return std::max(Drive::two_cycles(series), 0.025);
}

OffsetRegression smoothed(const Drive& drive, const Series& accel) {
  OffsetRegression r;
  const Resampled mean = smooth(drive.on_grid(accel), smoothing(accel));
  for (const std::int64_t t_ns : accel.t_ns) {
    const double t = drive.seconds(t_ns);
    if (t < drive.begin + r.range || t > drive.end - r.range) continue;
    r.t.push_back(t);
    r.y.push_back(mean.at(t));
  }
  return r;
}

Resampled slope(const Resampled& signal) {
  return slope_around(signal, 2e-3);
}

double rms_of(const Resampled& signal) {
  double sum = 0.0;
  for (const double value : signal.value) sum += value * value;
  return std::sqrt(sum / static_cast<double>(std::max<std::size_t>(signal.value.size(), 1)));
}

// The side force that a car feels which turns as the gyro says: the inertia and the rear axle's
// slip, which builds up over the way σ, say what the tyres push,
//   α̇_h = (l_h ψ̇ - v_y - v α_h) / σ,  m a_y = (l C_h α_h + J_z ψ̈) / l_v,  v̇_y = a_y - v ψ̇
// and the sensor is at (p_x, p_y): a_y + ψ̈ p_x - ψ̇² p_y.
enum : Eigen::Index { late, stiffness, inertia, relaxation, lever_x, lever_y, gain, bias, numbers };

struct Turning {
  const daemon::Config& config;
  Resampled speed, yaw_rate, yaw_accel;
  std::vector<double> t;
};

Eigen::VectorXd side_force(const Turning& turning, const Eigen::VectorXd& p) {
  const estimator::Vehicle& car = turning.config.vehicle;
  const double stiff = car.cornering_stiffness_rear * std::exp(p[stiffness]);
  const double moment = car.yaw_inertia * std::exp(p[inertia]);
  const double sigma = 0.17 * car.wheelbase() * std::exp(p[relaxation]);
  constexpr double dt = 5e-3;
  double v_y = 0.0, slip = 0.0, before = 0.0, felt = 0.0;
  Eigen::VectorXd result(static_cast<Eigen::Index>(turning.t.size()));
  double t = turning.speed.begin;
  std::size_t next = 0;
  while (next < turning.t.size()) {
    const double v = turning.speed.at(t), r = turning.yaw_rate.at(t);
    const double turn = turning.yaw_accel.at(t);
    const double accel =
        (car.wheelbase() * stiff * slip + moment * turn) / (car.front_axle * car.mass);
    before = felt;
    felt = (1.0 + p[gain]) * (accel + turn * (turning.config.imu_position[0] + p[lever_x]) -
                              r * r * (turning.config.imu_position[1] + p[lever_y])) +
           p[bias];
    for (; next < turning.t.size() && turning.t[next] - p[late] <= t; ++next) {
      const double part = std::clamp(1.0 - (t - turning.t[next] + p[late]) / dt, 0.0, 1.0);
      result[static_cast<Eigen::Index>(next)] = before + part * (felt - before);
    }
    if (t > turning.speed.end() + 1.0) break;
    // The slip settles within a step where the way is short: implicit in it and in v_y.
    const double rate = dt * std::max(std::fabs(v), 0.05) / sigma;
    slip = (slip + dt * (car.rear_axle * r - v_y) / sigma) /
           (1.0 + rate + dt * dt * car.wheelbase() * stiff / (car.front_axle * car.mass * sigma));
    v_y += dt *
           ((car.wheelbase() * stiff * slip + moment * turn) / (car.front_axle * car.mass) - v * r);
    t += dt;
  }
  for (; next < turning.t.size(); ++next) result[static_cast<Eigen::Index>(next)] = felt;
  return result;
}

SourceOffset lateral(const Drive& drive, const Speed& speed) {
  const Series& series = drive.log.of(Source::accel_y);
  const OffsetRegression measured = smoothed(drive, series);
  SourceOffset result{
      Source::accel_y, "the gyro, by the side force of the turn", 0.0, 0.0, 0.0, ""};
  if (measured.t.size() < 50) {
    result.doubt = "too few samples";
    return result;
  }
  const double half = smoothing(series);
  Turning turning{
      drive.config, smooth(speed.value, half), smooth(drive.yaw_rate, half), {}, measured.t};
  turning.yaw_accel = slope(turning.yaw_rate);
  ResponseFit problem;
  problem.t = measured.t;
  problem.z = Eigen::Map<const Eigen::VectorXd>(measured.y.data(),
                                                static_cast<Eigen::Index>(measured.y.size()));
  problem.predicted = [&turning](const Eigen::VectorXd& p) { return side_force(turning, p); };
  const double wheelbase = drive.config.vehicle.wheelbase();
  problem.expected = Eigen::VectorXd::Zero(numbers);
  problem.doubt = Eigen::VectorXd::Zero(numbers);
  problem.doubt << 1.0, 0.15, 0.1, 0.5, 0.05 * wheelbase, 0.1 * wheelbase, 0.05, 2.0;
  std::vector<double> trials;
  for (double trial = -0.3; trial <= 0.3; trial += 0.02) trials.push_back(trial);
  problem.start = problem.expected;
  problem.start[late] = best_of(problem, late, trials);
  const FittedResponse found = fit(problem);
  result.offset = found.parameters[late];
  result.sigma = std::hypot(std::sqrt(found.covariance(late, late)), unmodelled_side_force);
  result.explained = found.explained;
  if (found.explained < 0.5)
    result.doubt = "it does not follow the turns: sign, mounting, or it shakes";
  return result;
}

// a_x = dv/dt - v_y ψ̇ - ψ̇² p_x - ψ̈ p_y + b
SourceOffset longitudinal(const Drive& drive, const Speed& speed) {
  const Series& series = drive.log.of(Source::accel_x);
  OffsetRegression r = smoothed(drive, series);
  const Resampled yaw_rate = smooth(drive.yaw_rate, smoothing(series));
  const Resampled v = smooth(speed.value, smoothing(series));
  const Resampled turn2 = times(yaw_rate, yaw_rate);
  const Resampled wide = times(turn2, times(v, v));
  const Resampled accel = slope(v);
  const estimator::Vehicle& car = drive.config.vehicle;
  const double slip = car.mass * car.front_axle / (car.wheelbase() * car.cornering_stiffness_rear);
  const double scrub = car.mass * car.rear_axle / (car.wheelbase() * car.cornering_stiffness_front);
  r.basis = {{accel, 1.0, 0.05},
             {turn2, 0.0, car.wheelbase()},
             {wide, 0.0, slip + scrub},
             {slope(yaw_rate), -drive.config.imu_position[1], 0.2 * car.wheelbase()},
             {slope(times(v, accel)), 0.0, speed.driven ? 0.02 : 0.001},
             {constant(accel)}};
  const Offset found = solve(r);
  SourceOffset result =
      as_offset(Source::accel_x, speed.driven ? "driven wheels' speed" : "wheels' speed", found);
  result.sigma = std::hypot(result.sigma, speed.offset_sigma);
  // In a turn the tyres drag, too, and v_y follows late, by some hundredths of a second that no
  // model of this knows: what is not dv/dt may pull the offset along.
  const double in_turns = rms_of(combined(turn2, wide, [&](double a, double b) {
    return found.coefficients[1] * a + found.coefficients[2] * b;
  }));
  const double share = in_turns / std::max(std::fabs(found.coefficients[0]) * rms_of(accel), 1e-9);
  result.sigma = std::hypot(result.sigma, 0.03 * share);
  return result;
}

}  // namespace

LatencyEstimate estimate_latencies(const daemon::Config& config, const SignalLog& log,
                                   std::span<const estimator::CameraPose> camera) {
  const Series& gyro = log.of(Source::yaw_rate);
  if (gyro.size() < 2) {
    throw std::invalid_argument(config.file.string() +
                                ": can.signals.yaw_rate: the log has no sample of it, and every "
                                "latency is found against the gyro");
  }
  Drive drive{config, log, 0.0, 0.0, {}, {}};
  drive.begin = drive.seconds(gyro.t_ns.front());
  drive.end = drive.seconds(gyro.t_ns.back());
  if (drive.end - drive.begin < 10.0) {
    throw std::invalid_argument("the log holds " + fixed(drive.end - drive.begin, 1) +
                                " s of gyro; ten are needed, a minute of brisk driving is better");
  }
  drive.yaw_rate = drive.on_grid(gyro);
  drive.turned = integral(drive.yaw_rate);

  LatencyEstimate result;
  const auto mapped = [&](Source source) { return log.of(source).size() > 1; };
  double camera_offset = 0.0;
  bool camera_placed = false;
  if (!camera.empty()) {
    result.offsets.push_back(camera_yaw(drive, camera));
    camera_placed = result.offsets.back().doubt.empty();
    camera_offset = result.offsets.back().offset;
  }
  for (const auto& [left, right] : {std::pair{Source::wheel_front_left, Source::wheel_front_right},
                                    std::pair{Source::wheel_rear_left, Source::wheel_rear_right}}) {
    if (!mapped(left) || !mapped(right)) continue;
    result.offsets.push_back(wheel_pair(drive, left, right));
    SourceOffset other = result.offsets.back();
    other.source = right;
    result.offsets.push_back(std::move(other));
  }
  for (const Source source :
       {Source::wheel_front_left, Source::wheel_front_right, Source::wheel_rear_left,
        Source::wheel_rear_right, Source::wheel_rear, Source::motor}) {
    if (!mapped(source)) continue;
    const bool paired = std::ranges::any_of(
        result.offsets, [source](const SourceOffset& done) { return done.source == source; });
    if (paired) continue;
    if (camera_placed) {
      result.offsets.push_back(speed_by_camera(drive, source, camera, camera_offset));
    } else {
      result.offsets.push_back({source, "the camera's way", 0.0, 0.0, 0.0,
                                "one wheel speed alone says nothing of turns; with --camera its "
                                "way can be compared"});
    }
  }
  if (const auto speed = best_speed(drive, result.offsets)) {
    if (mapped(Source::accel_x)) result.offsets.push_back(longitudinal(drive, *speed));
    if (mapped(Source::accel_y)) result.offsets.push_back(lateral(drive, *speed));
    if (mapped(Source::steering))
      result.steering = steering_response(config.vehicle, drive.on_grid(log.of(Source::steering)),
                                          smooth(speed->value, 0.04), gyro, log.first_ns);
  }
  return result;
}

}  // namespace odomd::tools
