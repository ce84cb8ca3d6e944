// A camera that stays off, or whose clock drifts: faults that are too small for any single instant.
//
// docs/model.md, "Integrity".
#pragma once

#include <array>
#include <cstdint>

namespace odomd::estimator::integrity {

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
