// A car with a known odometry, and late camera poses of it.
#pragma once

#include "estimator/baselines/pose_anchor.hpp"
#include "tests/estimator/drive.hpp"
#include "tests/gtest.hpp"

namespace odomd::estimator::testing::pose_anchor_test {

inline constexpr std::int64_t start_ns = 1'000'000'000;

/// A car that drives a circle of 0.5 m radius at 1 m/s in its odometry frame.
class PoseAnchorTest : public ::testing::Test {
 protected:
  static constexpr BodyVelocity velocity{1.0, 0.05, 2.0};
  static constexpr Symmetric3 velocity_covariance{4e-4, 0.0, 0.0, 1e-4, 0.0, 1e-3};

  void SetUp() override { begin(); }

  void begin(const FilterSettings& settings = {}) {
    anchor_ = PoseAnchor{settings};
    anchor_.set_pose({});
    now_ = start_ns;
  }
  void begin_from_camera() {
    FilterSettings settings;
    settings.initialise_from_camera = true;
    anchor_ = PoseAnchor{settings};
  }

  void drive(int ticks, double noise_factor = 1.0) {
    for (int i = 0; i < ticks; ++i) {
      now_ += period_ns;
      anchor_.extend(now_, {.velocity = velocity,
                            .covariance = packed(noise_factor * unpacked(velocity_covariance)),
                            .mean = velocity,
                            .way = moved({}, velocity, 0.005)});
    }
    expect_covariance();
  }

  /// The odometry pose at a time.
  static Pose2 odom_at(std::int64_t time_ns) {
    return moved({}, velocity, static_cast<double>(time_ns - start_ns) * 1e-9);
  }

  /// A camera pose captured `latency_ns` before now, that sees the car at `map`.
  [[nodiscard]] CameraPose seen(const Pose2& map, std::int64_t latency_ns,
                                double sigma = 0.01) const {
    return {now_ - latency_ns, now_, map.x, map.y, map.yaw, sigma, sigma, sigma};
  }

  /// The same for a car whose odometry frame lies at `anchor` in the map.
  [[nodiscard]] CameraPose seen_at(const Pose2& anchor, std::int64_t latency_ns,
                                   double sigma = 0.01) const {
    return seen(compose(anchor, odom_at(now_ - latency_ns)), latency_ns, sigma);
  }

  Verdict take(const CameraPose& camera) {
    const Verdict verdict = anchor_.take(camera, now_ + period_ns, now_);
    expect_covariance();
    return verdict;
  }

  void expect_covariance() const {
    EXPECT_TRUE(!anchor_.initialised() || is_positive_definite(anchor_.covariance()));
  }

  PoseAnchor anchor_{FilterSettings{}};
  std::int64_t now_ = start_ns;
};

}  // namespace odomd::estimator::testing::pose_anchor_test
