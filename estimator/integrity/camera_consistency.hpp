// The car's motion between two camera poses; lasting errors and a drifting clock of a camera.
//
// docs/model.md, "Integrity".
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>

#include "estimator/common/measurement.hpp"
#include "estimator/common/pose.hpp"
#include "estimator/common/symmetric3.hpp"
#include "estimator/common/time.hpp"

namespace odomd::estimator::integrity {

/// The car's motion from one camera pose to another, along its mean heading and to the left.
struct CameraStep {
  double dt = 0.0;      ///< [s]
  double along = 0.0;   ///< [m]
  double across = 0.0;  ///< [m]
  double turned = 0.0;  ///< [rad]
};

[[nodiscard]] inline CameraStep step_between(const CameraPose& from,
                                             const CameraPose& to) noexcept {
  const double turned = wrap_angle(to.yaw - from.yaw);
  const double c = std::cos(from.yaw + 0.5 * turned);
  const double s = std::sin(from.yaw + 0.5 * turned);
  const double x = to.x - from.x;
  const double y = to.y - from.y;
  return {seconds_between(from.capture_ns, to.capture_ns), c * x + s * y, c * y - s * x, turned};
}

/// Mean of the normalised innovations of the last camera poses, which shows a lasting error.
class CameraConsistency {
 public:
  /// ν and its variances, of x, y and yaw. An exponential mean with the share g has g / (2 - g)
  /// times the variance of a sample.
  void add(const std::array<double, 3>& innovation,
           const std::array<double, 3>& variance) noexcept {
    constexpr double poses = 100.0;
    constexpr double threshold = 35.0;  // χ²₃, P = 1e-7: one false alarm in 10⁴ h at 3 s per window
    constexpr double most = 5.0;        // limit of one innovation [sigmas]
    constexpr double share = 2.0 / (poses + 1.0);
    double sum = 0.0;
    for (std::size_t i = 0; i < mean_.size(); ++i) {
      const double normalised = std::clamp(innovation[i] / std::sqrt(variance[i]), -most, most);
      mean_[i] += share * (normalised - mean_[i]);
      sum += squared(mean_[i]) * (2.0 - share) / share;
    }
    contradicted_ = sum > threshold;
  }
  [[nodiscard]] bool contradicted() const noexcept { return contradicted_; }

 private:
  std::array<double, 3> mean_{};
  bool contradicted_ = false;
};

/// Detects a camera clock with another rate: the latency of the poses grows or falls.
class CameraClock {
 public:
  /// From an exponential mean m and its own mean m' the slope is (m - m') / T; with white noise σ
  /// its variance is σ² Δt / (4 T³).
  void add(std::int64_t capture_ns, std::int64_t arrival_ns) noexcept {
    constexpr double average_s = 3.0;
    constexpr double longest_gap_s = 1.0;
    constexpr double sigmas = 6.0;
    constexpr double largest_drift = 1e-3;  // a crystal drifts by a tenth of this
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
  [[nodiscard]] bool drifts() const noexcept { return drifts_; }

 private:
  std::int64_t since_ns_ = 0;
  std::int64_t time_ns_ = 0;
  double mean_ = 0.0;  ///< exponential mean of the latency [s]
  double slow_ = 0.0;  ///< exponential mean of `mean_` [s]
  double variance_ = 0.0;
  bool drifts_ = false;
};

}  // namespace odomd::estimator::integrity
