// One fault in a stream of camera poses, of the camera's reference point.
#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "estimator/common/measurement.hpp"
#include "tools/fault/fault.hpp"
#include "tools/math/random.hpp"

namespace odomd::fault {

/// For one stream, and for use by one thread.
class CameraFault {
 public:
  /// `fault` must be a fault of the camera.
  CameraFault(const Fault& fault, ActiveTime span);

  /// Takes a pose and appends the poses that are due by its arrival time.
  void take(const estimator::CameraPose& pose, std::vector<estimator::CameraPose>& out);
  /// Appends the held-back poses that are due by `now_ns`.
  void release(std::int64_t now_ns, std::vector<estimator::CameraPose>& out);

  /// The number of poses affected so far.
  [[nodiscard]] std::uint64_t acted_on() const noexcept { return poses_; }

 private:
  [[nodiscard]] estimator::CameraPose changed(const estimator::CameraPose& pose,
                                              std::uint64_t number);
  void add_noise(estimator::CameraPose& pose, double sigmas);

  Fault fault_;
  ActiveTime span_;
  sim::RandomStream random_;
  std::optional<estimator::CameraPose> latest_;   ///< the last one before the fault
  std::array<estimator::CameraPose, 2> shown_{};  ///< the two poses before the newest one
  std::uint64_t poses_ = 0;                       ///< received during the fault
  std::vector<estimator::CameraPose> held_;       ///< in order of arrival
};

}  // namespace odomd::fault
