// docs/model.md, "Parities over seconds".
#include "estimator/integrity/slow_parity.hpp"

#include <algorithm>

#include <Eigen/LU>

#include "estimator/common/squares.hpp"
#include "estimator/integrity/hypotheses.hpp"
#include "estimator/integrity/integrated_speed.hpp"

namespace odomd::estimator::integrity {
namespace {

constexpr double slow_s = 10.0;

/// χ² of n degrees with P = 2.8e-7: of windows of slow_s, one false alarm in 10⁴ hours. Exact for
/// n = 2, t = 2 ln(10⁴ · 3600 / slow_s); to 2 % up to n = 12.
constexpr double gate_of(double degrees) noexcept {
  return 26.0 + 2.1 * degrees;
}

}  // namespace

void Regression::add(double x, double y, const Prior& prior, double dt) noexcept {
  const Eigen::Vector2d a(x, 1.0);
  const double weight = dt / squared(prior.noise);
  information_ += weight * a * a.transpose();
  moment_ += weight * (y - (1.0 + prior.scale) * x) * a;
  prior_ += weight * Eigen::Vector2d(squared(prior.scale_sigma), squared(prior.offset_sigma));
  weight_ += weight;
}

void Regression::fade(double dt) noexcept {
  const double kept = std::exp(-dt / slow_s);
  information_ *= kept;
  moment_ *= kept;
  prior_ *= kept;
  weight_ *= kept;
}

/// (s, o) = N⁻¹ m with covariance S = N⁻¹ + P₀; misfit = (s, o) S⁻¹ (s, o)ᵀ.
Regression::Deviation Regression::deviation() const noexcept {
  constexpr double unknown = 1e-6;  // information without any sample
  if (weight_ < unknown) {
    return {};
  }
  const Eigen::Matrix2d inverse =
      Eigen::Matrix2d(information_ + unknown * Eigen::Matrix2d::Identity()).inverse();
  Deviation result;
  result.value = inverse * moment_;
  Eigen::Matrix2d S = inverse;
  S.diagonal() += prior_ / weight_;
  result.variance = S.diagonal();
  result.misfit = result.value.dot(Eigen::Matrix2d(S.inverse()) * result.value);
  return result;
}

void SlowParities::add(const Sensors& sensors, const Observations& observed, bool backwards,
                       double dt) noexcept {
  constexpr double slowest_turn = 0.05;  // [rad/s]
  constexpr double skew_s = 0.02;
  constexpr double speed_scale = 0.03;
  for (auto& regressions : turns_) {
    for (Regression& regression : regressions) {
      regression.fade(dt);
    }
  }
  // 1. Each reference against the gyro.
  const SourceHistory& gyro = observed.history(Source::yaw_rate);
  const double v = observed.speed();
  const double yaw_rate = gyro.mean() - observed.errors.gyro_bias;
  const double skew = skew_s * std::abs(gyro.rate(Over::short_time));
  // Of a sensor, per √Hz.
  const auto white = [](const SourceHistory& sensor) {
    return sensor.sigma * std::sqrt(sensor.cycle_s);
  };
  auto& [of_accel, of_wheels, of_camera] = turns_[yaw_rate > 0.0 ? 1 : 0];
  const bool grips = !observed.slides(observed.now_ns, 4.0 * mean_s.back());
  if (gyro.alive(observed.now_ns) && std::abs(v) > min_learning_speed &&
      std::abs(yaw_rate) > slowest_turn) {
    turned_s_ += dt;
    const Tuning& tuning = sensors.tuning;
    const double scale = root_of_squares(tuning.gyro_scale, 0.02);
    const double bias = std::max(0.01, observed.errors.gyro_bias_sigma);
    if (grips && observed.usable(Source::accel_y)) {
      // a_y = v ψ̇ (1 + ρ): a body rolls outwards, by 0 to `roll_gradient`.
      constexpr double bank = 0.03;   // [g], the road's
      constexpr double noise = 0.01;  // [g]
      const double roll = 0.5 * tuning.roll_gradient;
      const SourceHistory& accel = observed.history(Source::accel_y);
      of_accel.add(
          v * yaw_rate, accel.mean(),
          {.scale = roll,
           .scale_sigma = root_of_squares(scale, speed_scale, tuning.accel_scale, roll),
           .offset_sigma = root_of_squares(tuning.accel_bias, bank * gravity, v * bias),
           .noise = root_of_squares(noise * gravity, v * skew, white(accel), v * white(gyro))},
          dt);
    }
    if (grips && observed.usable(Source::wheel_rear_left) &&
        observed.usable(Source::wheel_rear_right)) {
      // ψ̇ = (v_r - v_l) / w, with the radii and the load transfer as in the instant's parity.
      const double width = sensors.car.track_width;
      const double outer = observed.load * v * yaw_rate / gravity;
      const auto speed = [&](Source wheel, double load) {
        return observed.history(wheel).mean() / (1.0 + observed.radius[index_of(wheel)] + load);
      };
      const double difference =
          speed(Source::wheel_rear_right, outer) - speed(Source::wheel_rear_left, -outer);
      of_wheels.add(yaw_rate, (backwards ? -difference : difference) / width,
                    {.scale_sigma = root_of_squares(
                         scale, 0.05, 2.0 * observed.load_sigma * v * v / (gravity * width)),
                     .offset_sigma = root_of_squares(2.0 * tuning.wheel_radius * v / width, bias),
                     .noise = root_of_squares(0.004 * v / width, skew)},
                    dt);
    }
    if (observed.camera_yaw_rate.alive(observed.now_ns)) {
      of_camera.add(yaw_rate, observed.camera_yaw_rate.mean(),
                    {.scale_sigma = root_of_squares(scale, 0.03),
                     .offset_sigma = root_of_squares(0.01, bias),
                     .noise = root_of_squares(0.04, 3.0 * skew)},
                    dt);
    }
  }
  // 2. The gyro explains deviations that are alike, a reference only its own.
  std::array<double, references> own{};
  double total = 0.0;
  double by_gyro = 0.0;
  double degrees = 0.0;
  for (const auto& regressions : turns_) {
    double weight = 0.0;
    double sum = 0.0;
    double squares = 0.0;
    for (std::size_t i = 0; i < references; ++i) {
      const Regression::Deviation off = regressions[i].deviation();
      own[i] += off.misfit;
      total += off.misfit;
      degrees += off.misfit > 0.0 ? 2.0 : 0.0;
      by_gyro += squared(off.value[1]) / off.variance[1];
      weight += 1.0 / off.variance[0];
      sum += off.value[0] / off.variance[0];
      squares += squared(off.value[0]) / off.variance[0];
    }
    by_gyro += squares - sum * sum / weight;
  }
  contradicted_ = turned_s_ > 0.5 * slow_s && total > gate_of(degrees);
  faulty_ = 0;
  if (!contradicted_) {
    return;
  }
  constexpr std::array source_of{only(Source::accel_y), Sources{0}, only(Source::camera)};
  const auto worst = static_cast<std::size_t>(std::ranges::max_element(own) - own.begin());
  const double by_worst = total - own[worst];
  faulty_ = by_gyro + margin < by_worst   ? only(Source::yaw_rate)
            : by_worst + margin < by_gyro ? source_of[worst]
                                          : 0;
}

/// An exponential mean with the share g has the variance g / (2 - g) of a sample.
void CameraConsistency::add(const std::array<double, 3>& innovation,
                            const std::array<double, 3>& variance) noexcept {
  constexpr double poses = 100.0;
  constexpr double threshold = 35.0;  // χ²₃ with P = 1e-7: at a window in 3 s one in 10⁴ hours
  constexpr double most = 5.0;        // of an outlier [sigmas]
  constexpr double share = 2.0 / (poses + 1.0);
  double sum = 0.0;
  for (std::size_t i = 0; i < mean_.size(); ++i) {
    const double normalised = std::clamp(innovation[i] / std::sqrt(variance[i]), -most, most);
    mean_[i] += share * (normalised - mean_[i]);
    sum += squared(mean_[i]) * (2.0 - share) / share;
  }
  contradicted_ = sum > threshold;
}

/// The slope of an exponential mean m and of its mean m' is (m - m') / T; of white noise σ it has
/// the variance σ² Δt / (4 T³).
void CameraClock::add(std::int64_t capture_ns, std::int64_t arrival_ns) noexcept {
  constexpr double average_s = 3.0;
  constexpr double longest_gap_s = 1.0;
  constexpr double sigmas = 6.0;
  constexpr double largest_drift = 1e-3;  // a crystal's is a tenth of it
  if (arrival_ns == 0) {
    return;
  }
  const double latency = seconds_between(capture_ns, arrival_ns);
  const double dt = seconds_between(time_ns_, arrival_ns);
  if (time_ns_ == 0 || dt > longest_gap_s) {
    *this = {};
    since_ns_ = arrival_ns;
    mean_ = slow_ = latency;
  } else if (dt > 0.0) {
    const double share = dt / std::min(average_s, seconds_between(since_ns_, arrival_ns) + dt);
    variance_ += share * (squared(latency - mean_) - variance_);
    mean_ += share * (latency - mean_);
    slow_ += share * (mean_ - slow_);
    const double slope = (mean_ - slow_) / average_s;
    const double sigma = std::sqrt(variance_ * dt / average_s) / (2.0 * average_s);
    drifts_ = seconds_between(since_ns_, arrival_ns) > 2.0 * average_s &&
              std::abs(slope) > largest_drift + sigmas * sigma;
  }
  time_ns_ = arrival_ns;
}

}  // namespace odomd::estimator::integrity
