// The transform from the odometry frame to the map, and its updates from late camera poses.
// docs/model.md, "The odometry frame, the map, and the camera" and "The covariance of the
// baselines".
//
//   map = map_from_odom ∘ odom
//
// The odometry never jumps. A ring holds the last 256 ticks (1.28 s at 5 ms), so that a camera pose
// sets map_from_odom at its capture time. From then on the covariance of the map pose is the
// camera's covariance, plus the noise of all later ticks and the effect of lasting errors.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <limits>

#include "estimator/baselines/motion.hpp"
#include "estimator/common/estimate.hpp"
#include "estimator/common/measurement.hpp"
#include "estimator/common/pose.hpp"
#include "estimator/common/settings.hpp"
#include "estimator/common/symmetric3.hpp"

namespace odomd::estimator {

class PoseAnchor {
 public:
  static constexpr std::size_t ring_ticks = 256;
  static constexpr int rejections_to_accept = 10;

  explicit PoseAnchor(const FilterSettings& settings) noexcept;

  /// Sets the map pose of the newest tick, and its covariance to initial_sigma². The first call
  /// initialises the anchor, and also starts the odometry frame there.
  void set_pose(const Pose2& pose) noexcept;

  /// Resumes from a predecessor: its poses in both frames, map covariance, reset count.
  void resume(const Estimate& predecessor) noexcept;

  /// Appends a tick. The velocity's error is white from tick to tick, except for the lasting
  /// errors. If a gap precedes the tick's period, the motion in the gap is unknown.
  void extend(std::int64_t time_ns, const Motion& motion) noexcept;

  /// Gates a camera pose against the map pose at the capture time and, if it is fused, re-anchors.
  /// `latest_ns` is the limit for capture times. A pose that arrives later than the settings allow
  /// is too_old. An initialising pose may be from before the first tick.
  Verdict take(const CameraPose& camera, std::int64_t latest_ns, std::int64_t arrival_ns) noexcept;

  [[nodiscard]] bool started() const noexcept { return last_ > 0; }
  [[nodiscard]] bool initialised() const noexcept { return initialised_; }
  [[nodiscard]] const Pose2& odom() const noexcept { return tick(last_).odom; }
  [[nodiscard]] Pose2 map() const noexcept { return compose(map_from_odom_, odom()); }
  [[nodiscard]] Symmetric3 covariance() const noexcept { return packed(tick(last_).covariance); }

  [[nodiscard]] std::uint32_t reset_count() const noexcept { return reset_count_; }
  [[nodiscard]] const Pose2& last_jump() const noexcept { return last_jump_; }
  [[nodiscard]] std::int64_t camera_ns() const noexcept { return fused_capture_ns_; }
  [[nodiscard]] double test_ratio() const noexcept { return test_ratio_; }

 private:
  struct Tick {
    std::int64_t time_ns = 0;
    Pose2 odom;
    BodyVelocity velocity;  ///< mean since the previous tick
    /// Covariance of the displacement since the previous tick, in odometry axes.
    Eigen::Matrix3d noise = Eigen::Matrix3d::Zero();
    Eigen::Matrix3d by_errors = Eigen::Matrix3d::Zero();  ///< ∂(displacement) / ∂(lasting errors)
    Eigen::Matrix3d covariance = Eigen::Matrix3d::Zero();  ///< of the map pose, map axes
  };
  struct Place {
    Pose2 odom;
    std::size_t next;  ///< first tick at or after this place; otherwise the newest
    double steps;      ///< from this place to that tick, in periods
  };
  struct RejectedPose {
    std::int64_t capture_ns = 0;
    Pose2 map, odom;
    Eigen::Vector3d variance = Eigen::Vector3d::Zero();
  };

  [[nodiscard]] const Tick& tick(std::size_t k) const noexcept { return ring_[k % ring_ticks]; }
  [[nodiscard]] Tick& tick(std::size_t k) noexcept { return ring_[k % ring_ticks]; }
  [[nodiscard]] std::size_t oldest() const noexcept {
    return last_ < ring_ticks ? 0 : last_ - ring_ticks + 1;
  }
  [[nodiscard]] Place place(std::int64_t time_ns) const noexcept;
  [[nodiscard]] bool accepts_run(const RejectedPose& rejected) noexcept;
  void grow(const Pose2& from, Tick& to, double steps) noexcept;
  void re_anchor(Place at, const Pose2& map, const Eigen::Matrix3d& covariance) noexcept;

  FilterSettings settings_;
  std::array<Tick, ring_ticks> ring_{};
  std::size_t last_ = 0;  ///< the newest tick's number, counted from the start of the history

  // Uncertainty of the newest map pose, propagated from the last set or camera pose; map axes
  Eigen::Matrix3d white_ = squared(initial_sigma) *
                           Eigen::Matrix3d::Identity();  ///< covariance without the lasting errors
  Eigen::Matrix3d sensitivity_ = Eigen::Matrix3d::Zero();  ///< ∂pose / ∂(lasting errors)
  Eigen::Vector3d error_variance_ = Eigen::Vector3d::Zero();

  bool initialised_ = false;
  Pose2 map_from_odom_;
  std::uint32_t reset_count_ = 0;
  Pose2 last_jump_;

  std::int64_t judged_capture_ns_ = 0;  ///< of the last camera pose that was gated or fused
  std::int64_t fused_capture_ns_ = 0;   ///< 0: none yet
  double test_ratio_ = 0.0;
  RejectedPose last_rejected_;
  int rejected_in_a_row_ = 0;  ///< poses that agree with each other, since the last fused one
  std::int64_t suspect_until_ns_ = std::numeric_limits<std::int64_t>::min();  ///< of the odometry
};

}  // namespace odomd::estimator
