// When each mode is entered and left; no mode flaps.
#include "estimator/integrity/mode_monitor.hpp"
#include "tests/gtest.hpp"

namespace odomd::estimator::mode_monitor_test {
namespace {

constexpr std::int64_t period_ns = 5'000'000;
constexpr std::int64_t millisecond = 1'000'000;

class ModeMonitorTest : public ::testing::Test {
 protected:
  Mode run(double seconds, Estimate e) {
    const auto ticks = static_cast<int>(seconds * 200.0);
    for (int i = 0; i < ticks; ++i) {
      e.time_ns = now_ += period_ns;
      const Mode mode = modes_.update(e, modes_.is_still(e.v_x, e.yaw_rate));
      changes_ += mode != mode_ ? 1 : 0;
      mode_ = mode;
    }
    return mode_;
  }

  /// Drives with a camera pose every `interval_ms`.
  Mode run_with_camera(double seconds, std::int64_t interval_ms) {
    const std::int64_t end = now_ + static_cast<std::int64_t>(seconds * 1e9);
    while (now_ < end) {
      if (now_ >= camera_ + interval_ms * millisecond) camera_ = now_;
      run(0.005, {.initialised = true, .v_x = 1.0, .camera_ns = camera_});
    }
    return mode_;
  }

  ModeMonitor modes_;
  std::int64_t now_ = 1'000'000'000;
  std::int64_t camera_ = 0;
  Mode mode_ = Mode::initialising;
  int changes_ = 0;
};

TEST_F(ModeMonitorTest, InitialisingUntilThereIsAPoseAndAFaultComesFirst) {
  EXPECT_EQ(run(0.1, {.initialised = false, .v_x = 1.0}), Mode::initialising);
  EXPECT_EQ(run(0.1, {.initialised = true, .v_x = 1.0}), Mode::dead_reckoning);
  EXPECT_EQ(run(1.0, {.initialised = false, .model_fault = true}), Mode::fault);
}

TEST_F(ModeMonitorTest, StandsAfterHalfASecondOfRestUntilTheWheelsTurn) {
  EXPECT_EQ(run(0.5, {.initialised = true}), Mode::dead_reckoning);
  EXPECT_EQ(run(0.01, {.initialised = true}), Mode::standstill);
  EXPECT_EQ(run(0.005, {.initialised = true, .v_x = -0.03}), Mode::dead_reckoning);
}

TEST_F(ModeMonitorTest, TurningWithoutWheelSpeedIsNoStandstill) {
  EXPECT_EQ(run(1.0, {.initialised = true, .yaw_rate = -0.15}), Mode::dead_reckoning);
}

TEST_F(ModeMonitorTest, SpeedAroundTheThresholdDoesNotFlap) {
  run(1.0, {.initialised = true});
  changes_ = 0;
  for (int i = 0; i < 100; ++i)
    run(0.005, {.initialised = true, .v_x = i % 2 == 0 ? 0.015 : 0.005});
  EXPECT_EQ(mode_, Mode::standstill);
  EXPECT_EQ(changes_, 0);
}

TEST_F(ModeMonitorTest, TracksWithTheCameraAndLeavesAfterItsTimeout) {
  EXPECT_EQ(run_with_camera(0.5, 35), Mode::tracking);
  const std::int64_t last_seen = camera_;
  const Estimate blind{.initialised = true, .v_x = 1.0, .camera_ns = camera_};
  EXPECT_EQ(run(0.4, blind), Mode::tracking);
  EXPECT_EQ(run(0.2, blind), Mode::dead_reckoning);
  EXPECT_GT(now_ - last_seen, 500 * millisecond);
  EXPECT_EQ(run_with_camera(0.2, 35), Mode::tracking);
}

TEST_F(ModeMonitorTest, RareCameraDoesNotMakeTheModeFlap) {
  run(0.1, {.initialised = true, .v_x = 1.0});
  changes_ = 0;
  EXPECT_EQ(run_with_camera(10.0, 600), Mode::dead_reckoning);
  EXPECT_EQ(changes_, 0);
}

}  // namespace
}  // namespace odomd::estimator::mode_monitor_test
