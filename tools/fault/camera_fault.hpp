// One fault in a stream of camera poses, of the camera's reference point.
#pragma once

#include <cstdint>
#include <optional>
#include <vector>

#include "estimator/common/measurement.hpp"
#include "tools/fault/fault.hpp"
#include "tools/sim/random.hpp"

namespace odomd::fault {

/// One stream, one thread.
class CameraFault {
 public:
  /// Of a kind of the camera's.
  CameraFault(const Fault& fault, Span span);

  /// Takes a pose and appends those that leave by its arrival.
  void take(const estimator::CameraPose& pose, std::vector<estimator::CameraPose>& out);
  /// Appends what was held back until `now_ns`.
  void release(std::int64_t now_ns, std::vector<estimator::CameraPose>& out);

 private:
  [[nodiscard]] estimator::CameraPose changed(const estimator::CameraPose& pose);
  void add_noise(estimator::CameraPose& pose, double sigmas);

  Fault fault_;
  Span span_;
  sim::RandomStream random_;
  std::optional<estimator::CameraPose> latest_;  ///< before the fault
  std::uint64_t poses_ = 0;                      ///< within the fault
  std::vector<estimator::CameraPose> held_;      ///< by arrival
};

/// A whole camera log through all faults that are the camera's. `start_ns`: from when their times
/// count.
[[nodiscard]] std::vector<estimator::CameraPose> with_faults(
    std::vector<estimator::CameraPose> poses, const std::vector<Fault>& faults,
    std::int64_t start_ns);

}  // namespace odomd::fault
