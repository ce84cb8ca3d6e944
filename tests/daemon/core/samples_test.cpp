// Camera poses, mountings, and the age and flag of each source.
#include <numbers>

#include "daemon/core/mounting.hpp"
#include "daemon/core/source_watch.hpp"
#include "estimator/common/measurement.hpp"
#include "tests/gtest.hpp"

namespace odomd::daemon::samples_test {
namespace {

using estimator::Source;

estimator::CameraPose facing_north() {
  return {.capture_ns = 1,
          .arrival_ns = 2,
          .x = 10.0,
          .y = 20.0,
          .yaw = std::numbers::pi / 2,
          .sigma_x = 0.01,
          .sigma_y = 0.02,
          .sigma_yaw = 0.1};
}

TEST(CameraPose, MovesToTheCentreOfGravityWithTheYawError) {
  const double north = std::numbers::pi / 2;
  auto turned = facing_north();
  turned.yaw += 0.2;
  struct Case {
    estimator::CameraPose reference;
    std::array<double, 3> arm;
    double x, y, sigma_x;
  };
  const Case cases[]{{facing_north(), {}, 10.0, 20.0, 0.01},
                     // The reference point is ahead of and left of the centre of gravity: facing
                     // north that is 0.3 m north and 0.1 m west of it.
                     {facing_north(), {0.3, 0.1, 0.0}, 10.1, 19.7, std::hypot(0.01, 0.03)},
                     // The yaw error of 0.1 moves the end of the arm east-west.
                     {facing_north(), {0.3, 0.0, 0.0}, 10.0, 19.7, std::hypot(0.01, 0.03)},
                     // The mounting yaw is applied before the lever arm.
                     {turned, {0.3, 0.0, 0.2}, 10.0, 19.7, std::hypot(0.01, 0.03)}};
  for (const auto& [reference, arm, x, y, sigma_x] : cases) {
    const auto pose = to_centre_of_gravity(reference, arm);
    EXPECT_EQ(pose.capture_ns, 1);
    EXPECT_EQ(pose.arrival_ns, 2);
    EXPECT_NEAR(pose.x, x, 1e-12);
    EXPECT_NEAR(pose.y, y, 1e-12);
    EXPECT_NEAR(pose.yaw, north, 1e-12);
    EXPECT_NEAR(pose.sigma_x, sigma_x, 1e-12);
    EXPECT_NEAR(pose.sigma_y, arm[1] == 0.0 ? 0.02 : std::hypot(0.02, 0.01), 1e-12);
  }
}

can::Sample sample(Source source, double value) {
  return {.channel = static_cast<std::uint16_t>(source), .value = value};
}

TEST(ImuMounting, RotatesBothAxesIntoTheBodyFrame) {
  // The sensor's x axis points to the car's left: an acceleration along x pushes the car to the
  // left.
  std::array samples{sample(Source::yaw_rate, 0.7), sample(Source::accel_y, 2.0),
                     sample(Source::accel_x, 1.0)};
  turn_accelerations(samples, 0.5 * std::numbers::pi);
  EXPECT_EQ(samples[0].value, 0.7);
  EXPECT_NEAR(samples[1].value, 1.0, 1e-12);   // a_y
  EXPECT_NEAR(samples[2].value, -2.0, 1e-12);  // a_x
}

TEST(ImuMounting, InvalidatesASingleAxisAndKeepsOtherSamples) {
  std::array samples{sample(Source::accel_x, 1.0), sample(Source::steering, 0.2)};
  turn_accelerations(samples, 0.1);
  EXPECT_TRUE(std::isnan(samples[0].value));
  EXPECT_EQ(samples[1].value, 0.2);
}

constexpr std::size_t gyro = 0;
constexpr std::int64_t ms = 1'000'000;

TEST(SourceWatch, SourceWithoutASampleTimesOutFromTheStart) {
  SourceWatch watch;
  watch.configure(gyro, 30 * ms);
  EXPECT_EQ(watch.age_ns(gyro, 100 * ms), -1);
  EXPECT_FALSE(watch.healthy(gyro, 100 * ms));
  EXPECT_FALSE(watch.overdue(gyro, 130 * ms, 100 * ms));
  EXPECT_TRUE(watch.overdue(gyro, 131 * ms, 100 * ms));
}

TEST(SourceWatch, CountsAgeFromTheSampleAndTimeoutFromItsReception) {
  SourceWatch watch;
  watch.heard(gyro, 100 * ms, 60 * ms);  // 40 ms of known latency, longer than the time-out
  EXPECT_FALSE(watch.overdue(gyro, 10'000 * ms, 0)) << "it is not configured";
  EXPECT_FALSE(watch.healthy(gyro, 100 * ms));
  watch.configure(gyro, 30 * ms);
  EXPECT_EQ(watch.age_ns(gyro, 110 * ms), 50 * ms);
  EXPECT_TRUE(watch.healthy(gyro, 110 * ms));
  EXPECT_TRUE(watch.overdue(gyro, 131 * ms, 0));
  EXPECT_FALSE(watch.healthy(gyro, 131 * ms));
  watch.failed(gyro);
  EXPECT_TRUE(watch.failing(gyro));
  EXPECT_FALSE(watch.healthy(gyro, 101 * ms));
  watch.heard(gyro, 105 * ms, 105 * ms);
  EXPECT_TRUE(watch.healthy(gyro, 106 * ms)) << "a good sample ends the failure";
}

TEST(SourceWatch, UsablePoseOutweighsUnusableOnesInATick) {
  using estimator::SourceFlag;
  constexpr auto camera = static_cast<std::size_t>(estimator::Source::camera);
  for (const bool usable_first : {true, false}) {
    SourceWatch watch;
    if (usable_first) watch.usable_pose();
    for (int i = 0; i < 5; ++i) watch.unusable_pose();
    if (!usable_first) watch.usable_pose();
    watch.settle(5'000 * ms);
    EXPECT_EQ(watch.flag(camera), SourceFlag::ok);
    watch.unusable_pose();
    watch.settle(5'005 * ms);
    EXPECT_EQ(watch.flag(camera), SourceFlag::ok);
    watch.unusable_pose();
    watch.settle(5'010 * ms);
    EXPECT_EQ(watch.flag(camera), SourceFlag::non_finite);
  }
}

}  // namespace
}  // namespace odomd::daemon::samples_test
