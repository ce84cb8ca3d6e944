// One fault in a stream: takes the frames or camera poses of a car, and outputs those that a car
// with this fault would send. Camera poses are those of the camera's reference point.
#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "can_protocol/frame.hpp"
#include "estimator/common/measurement.hpp"
#include "tools/fault/car_signals.hpp"
#include "tools/fault/fault.hpp"
#include "tools/math/random.hpp"

namespace odomd::fault {

class FrameFault {
 public:
  /// `fault` may be of any kind except the camera's. `sigma`: the stated noise of each source;
  /// `span`: when the fault acts. `signals` must outlive this.
  FrameFault(const CarSignals& signals, const std::array<double, estimator::source_count>& sigma,
             const Fault& fault, ActiveTime span);

  /// Takes a frame and appends the frames that are due by its time, in order.
  void take(const can::Frame& frame, std::vector<can::Frame>& out);

  /// Appends the held-back frames that are due by `now_ns`; INT64_MAX: all of them.
  void release(std::int64_t now_ns, std::vector<can::Frame>& out);

  /// The number of frames affected so far.
  [[nodiscard]] std::uint64_t acted_on() const noexcept { return acted_on_; }

 private:
  struct Seen {
    std::optional<double> latest;  ///< as received
    std::optional<double> held;    ///< the latest value when the fault began
  };
  using Counters = std::array<can::E2eState, can::max_buses>;

  [[nodiscard]] bool touches(std::optional<std::size_t> message) const;
  void learn(std::size_t message, const can::Frame& frame);
  void change_values(std::size_t message, can::Frame& frame);
  [[nodiscard]] double changed(const Reading& reading, std::int64_t time_ns);
  [[nodiscard]] std::optional<double> partner(estimator::Source source) const;
  void flip(std::size_t message, can::Frame& frame);
  [[nodiscard]] bool keeps_order() const noexcept;
  void keep_order(std::optional<std::size_t> message, const can::Frame& frame,
                  std::vector<can::Frame>& out);
  void leave_at(std::int64_t time_ns, std::optional<std::size_t> message, const can::Frame& frame,
                std::vector<can::Frame>& out);
  void stamp_anew(std::optional<std::size_t> message, const can::Frame& frame,
                  std::vector<can::Frame>& out);
  void reorder(std::size_t message, const can::Frame& frame, std::vector<can::Frame>& out);
  void renumber(std::size_t message, can::Frame& frame);

  const CarSignals& signals_;
  Fault fault_;
  Sources sources_;
  ActiveTime span_;
  sim::RandomStream random_;
  std::array<double, estimator::source_count> sigma_{};
  std::array<Seen, estimator::source_count> seen_{};
  std::array<Reading, can::max_samples_per_frame> readings_{};
  std::vector<can::Frame> held_;                          ///< in order of output time
  std::vector<std::optional<can::Frame>> first_of_pair_;  ///< per message
  std::vector<Counters> counters_;                        ///< per message: of the last output frame
  std::vector<std::int64_t> stamped_ns_;  ///< last stamp per message, then of all other frames
  bool renumbers_ = false;
  std::uint64_t acted_on_ = 0;
};

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
