// Where the odometry frame lies in the map: map <- odometry, the covariance of the map pose, and
// what a late camera pose does to both. docs/model.md, "The odometry frame, the map, and the
// camera" and "The covariance of the baselines".
//
// The odometry pose never jumps. A ring of its last 256 ticks (1.28 s at 5 ms) remembers it, so
// that a camera pose re-anchors the frame at the time the picture was taken:
//
//   map_from_odom = camera ∘ odom(t_capture)⁻¹
//
// The camera's covariance replaces that of the map pose there, and grows again along the ring.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>

#include "estimator/common/estimate.hpp"
#include "estimator/common/measurement.hpp"
#include "estimator/common/pose.hpp"
#include "estimator/common/settings.hpp"
#include "estimator/common/symmetric3.hpp"
#include "estimator/integrity/rejected_poses.hpp"

namespace odomd::estimator {

class PoseAnchor {
 public:
  static constexpr std::size_t ring_ticks = 256;

  explicit PoseAnchor(const FilterSettings& settings) noexcept;

  /// Sets the map pose of the newest tick, and its covariance from the settings. The first time
  /// this initialises, and the odometry frame starts there too.
  void set_pose(const Pose2& pose) noexcept;

  /// Goes on from a predecessor's poses in both frames, the covariance of the map's, its resets.
  void resume(const Estimate& predecessor) noexcept;

  /// Makes `time_ns` the start of the history, with the pose known so far.
  void start(std::int64_t time_ns) noexcept;

  /// Appends a tick. `noise` is the covariance that the step has added to the odometry pose, in
  /// odometry axes; `velocity` serves captures just after the tick.
  void extend(std::int64_t time_ns, const Pose2& odom, const Symmetric3& noise,
              const BodyVelocity& velocity) noexcept;

  /// Judges a camera pose and, when it is fused, re-anchors. At t_capture, with ν the difference to
  /// the map pose there and S the sum of both covariances, νᵀS⁻¹ν must not exceed the gate.
  /// `latest_ns` is the limit for captures; a pose that arrives late by more than the settings
  /// allow is too_old. One that initialises may have been taken before the history begins, or come
  /// before it does.
  Verdict take(const CameraPose& camera, std::int64_t latest_ns, std::int64_t arrival_ns) noexcept;

  [[nodiscard]] bool started() const noexcept { return count_ > 0; }
  [[nodiscard]] bool initialised() const noexcept { return initialised_; }
  [[nodiscard]] const Pose2& odom() const noexcept { return newest().odom; }
  [[nodiscard]] Pose2 map() const noexcept { return compose(map_from_odom_, newest().odom); }
  [[nodiscard]] const Symmetric3& covariance() const noexcept { return newest().covariance; }

  [[nodiscard]] std::uint32_t reset_count() const noexcept { return reset_count_; }
  [[nodiscard]] const Pose2& last_jump() const noexcept { return last_jump_; }
  [[nodiscard]] std::int64_t camera_ns() const noexcept { return fused_capture_ns_; }
  [[nodiscard]] double test_ratio() const noexcept { return test_ratio_; }

 private:
  struct Tick {
    std::int64_t time_ns = 0;
    Pose2 odom;
    Symmetric3 noise{};       ///< of the step that led here, odometry axes
    Symmetric3 covariance{};  ///< of the map pose, map axes
  };

  /// A time among the ticks, before or after them.
  struct Place {
    Pose2 odom;
    Symmetric3 covariance;  ///< of the map pose there
    std::size_t age = 0;    ///< of the first tick after it; else of the newest, which it lies past
    double steps = 0.0;     ///< between that tick and it, in steps that lead to that tick
  };

  [[nodiscard]] const Tick& newest() const noexcept { return ring_[head_]; }
  [[nodiscard]] std::size_t index(std::size_t age) const noexcept {
    return (head_ + ring_ticks - age) % ring_ticks;
  }
  [[nodiscard]] std::optional<Place> place(std::int64_t time_ns, bool initialises) const noexcept;
  void initialise(const Pose2& seen, Place at, const Symmetric3& covariance) noexcept;
  void re_anchor(const Place& at, const Pose2& map, const Symmetric3& covariance) noexcept;
  void rebase(const Pose2& odom_from_old) noexcept;

  FilterSettings settings_;
  Symmetric3 initial_covariance_{};

  std::array<Tick, ring_ticks> ring_{};
  std::size_t head_ = 0;
  std::size_t count_ = 0;  ///< ticks in the ring; 0 before start()
  BodyVelocity velocity_;

  bool initialised_ = false;
  Pose2 map_from_odom_;
  RejectedRun rejected_;  ///< since one was fused
  std::int64_t suspect_until_ns_ = 0;

  std::uint32_t reset_count_ = 0;
  Pose2 last_jump_;
  std::int64_t judged_capture_ns_ = 0;  ///< of the last camera pose that came as far as the gate
  std::int64_t fused_capture_ns_ = 0;
  double test_ratio_ = 0.0;
};

}  // namespace odomd::estimator
