// Parities over seconds: they detect faults that are too small for any single instant.
//
// docs/model.md, "Parities over seconds".
#pragma once

#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>

#include <Eigen/Core>

#include "estimator/common/time.hpp"
#include "estimator/integrity/parity.hpp"

namespace odomd::estimator::integrity {

/// Regression y = (1 + s̄ + s) x + o over an exponential window, compared with the s and o that a
/// car without a fault can have.
class Regression {
 public:
  /// Of a car without a fault: s̄, standard deviations of s and o, and the noise of y over 1 s.
  struct Prior {
    double scale = 0.0;
    double scale_sigma = 0.0;
    double offset_sigma = 0.0;
    double noise = 0.0;
  };
  void add(double x, double y, const Prior& prior, double dt) noexcept;
  void fade(double dt) noexcept;

  struct Deviation {
    Eigen::Vector2d value = Eigen::Vector2d::Zero();     ///< (s, o)
    Eigen::Vector2d variance = Eigen::Vector2d::Ones();  ///< with the prior's
    double misfit = 0.0;                                 ///< χ² of two degrees
  };
  [[nodiscard]] Deviation deviation() const noexcept;

 private:
  Eigen::Matrix2d information_ = Eigen::Matrix2d::Zero();  ///< N = Σ a aᵀ / σ², a = (x, 1)
  Eigen::Vector2d moment_ = Eigen::Vector2d::Zero();       ///< Σ a (y - (1 + s̄) x) / σ²
  Eigen::Vector2d prior_ = Eigen::Vector2d::Zero();        ///< weighted sum of its variances
  double weight_ = 0.0;
};

/// The gyro compared with all other sources of a yaw rate, left and right turns apart.
class SlowParities {
 public:
  /// `backwards`: unsigned wheel speeds count negative.
  void add(const Sensors& sensors, const Observations& observed, bool backwards,
           double dt) noexcept;

  /// The source whose fault explains the deviations; none without a deviation, or if the source
  /// cannot be isolated.
  [[nodiscard]] Sources faulty() const noexcept { return faulty_; }
  [[nodiscard]] bool contradicted() const noexcept { return contradicted_; }

 private:
  static constexpr std::size_t references = 3;  ///< accel_y, a pair of wheels, the camera

  std::array<std::array<Regression, references>, 2> turns_{};  ///< right, left
  double turned_s_ = 0.0;                                      ///< time in turns
  Sources faulty_ = 0;
  bool contradicted_ = false;
};

/// Mean of the normalised innovations of the last camera poses: an error that stays.
class CameraConsistency {
 public:
  /// ν and its variances, of x, y and yaw.
  void add(const std::array<double, 3>& innovation, const std::array<double, 3>& variance) noexcept;
  [[nodiscard]] bool contradicted() const noexcept { return contradicted_; }

 private:
  std::array<double, 3> mean_{};
  bool contradicted_ = false;
};

/// Whether the latency of the camera poses grows or falls: its clock has another rate.
class CameraClock {
 public:
  void add(std::int64_t capture_ns, std::int64_t arrival_ns) noexcept;
  [[nodiscard]] bool drifts() const noexcept { return drifts_; }

 private:
  std::int64_t since_ns_ = 0;
  std::int64_t time_ns_ = 0;
  double mean_ = 0.0;  ///< exponential mean of the latency [s] ...
  double slow_ = 0.0;  ///< ... and of this mean
  double variance_ = 0.0;
  bool drifts_ = false;
};

}  // namespace odomd::estimator::integrity
