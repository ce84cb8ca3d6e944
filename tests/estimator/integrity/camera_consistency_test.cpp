// Faults that pass the gate at every instant, and show only over seconds.
#include "estimator/integrity/camera_consistency.hpp"

#include "tests/gtest.hpp"

namespace odomd::estimator::integrity::camera_consistency_test {
namespace {

constexpr std::int64_t ms = 1'000'000;

TEST(CameraConsistency, DetectsAnErrorThatStays) {
  CameraConsistency good;
  CameraConsistency bad;
  for (int i = 0; i < 300; ++i) {
    const double noise = 1.5 * std::sin(2.3 * i);
    good.add({noise, -noise, noise}, {1.0, 1.0, 1.0});
    EXPECT_FALSE(good.contradicted());
    bad.add({0.2 * noise + 0.48, 0.0, 0.0}, {0.04, 1.0, 1.0});
  }
  EXPECT_TRUE(bad.contradicted());
}

TEST(CameraConsistency, ForgivesAnOutlier) {
  CameraConsistency camera;
  camera.add({50.0, -50.0, 3.0}, {1.0, 1.0, 1.0});
  EXPECT_FALSE(camera.contradicted());
}

bool drifts(double rate) {
  CameraClock clock;
  bool drifted = false;
  for (int i = 1; i < 1000; ++i) {
    const std::int64_t arrival_ns = 33 * ms * i;
    const double latency_s = 0.03 + 0.008 * std::sin(7.0 * i) + rate * 0.033 * i;
    clock.add(arrival_ns - static_cast<std::int64_t>(latency_s * 1e9), arrival_ns);
    drifted = drifted || clock.drifts();
  }
  return drifted;
}

TEST(CameraClock, DetectsAnotherRate) {
  EXPECT_TRUE(drifts(0.005));
  EXPECT_TRUE(drifts(-0.005));
  EXPECT_FALSE(drifts(0.0));
  EXPECT_FALSE(drifts(1e-4));
}

}  // namespace
}  // namespace odomd::estimator::integrity::camera_consistency_test
