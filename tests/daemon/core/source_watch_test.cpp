// How the pipeline reports its sources: overdue, unprotected, out of range, contradicted.
#include <cstring>
#include <limits>
#include <tuple>

#include "tests/daemon/core/pipeline_car.hpp"

namespace odomd::daemon::pipeline_test {
namespace {

TEST(SourceWatch, FailedProtectionUpdatesNothing) {
  const Car car;
  car.wheel_reads(0, 1000);
  car.gyro_reads(0, 100, 1);
  car.gyro_reads(1, 200, 1);  // the counter does not change
  const TickRecord& record = car.tick(5);
  EXPECT_EQ(car.count(gyro, Verdict::failed_protection), 1U);
  EXPECT_TRUE(record.pose.conditions & ODOM_COND_PROTECTION);
  EXPECT_FALSE(record.pose.health & (1U << gyro));
  EXPECT_EQ(record.details.source_age_ns[gyro], 5 * ms);  // age of the good frame

  car.gyro_reads(6, 300, 2);
  EXPECT_FALSE(car.tick(10).pose.conditions & ODOM_COND_PROTECTION);
}

TEST(SourceWatch, OverdueSourceIsNotHealthyAndDegradesTheMode) {
  const Car car;
  car.wheel_reads(0, 1000);
  car.gyro_reads(0, 0, 1);
  const TickRecord& fresh = car.tick(0);
  EXPECT_EQ(fresh.pose.conditions, 0U);
  EXPECT_EQ(fresh.pose.health, (1U << gyro) | (1U << wheel));

  car.wheel_reads(31, 1000);
  const TickRecord& late = car.tick(35);
  EXPECT_EQ(late.pose.conditions, static_cast<std::uint32_t>(ODOM_COND_SIGNAL_TIMEOUT));
  EXPECT_EQ(late.pose.health, 1U << wheel);
  EXPECT_EQ(late.pose.mode, ODOM_DEGRADED);
}

TEST(SourceWatch, FlagsImpossibleValuesUntilASecondAfterTheLast) {
  using estimator::SourceFlag;
  Config config = two_signals();
  config.can.bindings[1].message = "FLOAT";
  for (const auto& [bad, verdict, flag] :
       {std::tuple{1e6F, Verdict::gated, SourceFlag::out_of_range},
        {std::numeric_limits<float>::quiet_NaN(), Verdict::non_finite, SourceFlag::non_finite}}) {
    const Car car(config);
    const TickRecord* record = nullptr;
    for (const auto& [at_ms, value, expected] : {std::tuple{0, 1.5F, SourceFlag::ok},
                                                 {5, bad, SourceFlag::ok},
                                                 {7, 1.5F, SourceFlag::ok},
                                                 {10, bad, SourceFlag::ok},
                                                 {20, bad, flag},
                                                 {30, 1.5F, flag},
                                                 {1019, 1.5F, flag},
                                                 {1020, 1.5F, SourceFlag::ok}}) {
      can::Frame frame{.time_ns = start + at_ms * ms, .id = 258, .length = 4};
      std::memcpy(frame.data.data(), &value, sizeof value);
      car.pipeline->take(frame, frame.time_ns);
      record = &car.tick(at_ms);
      EXPECT_EQ(car.flag(wheel), expected) << at_ms;
      const bool faulty = (record->pose.conditions & ODOM_COND_SENSOR_FAULT) != 0;
      EXPECT_EQ(faulty, expected != SourceFlag::ok) << at_ms;
      EXPECT_EQ(record->pose.health >> wheel & 1U, faulty ? 0U : 1U) << at_ms;
    }
    EXPECT_EQ(car.count(wheel, verdict), 3U);
    EXPECT_NEAR(record->pose.vx, 1.5, 1e-9);
  }
}

TEST(SourceWatch, RejectsANonPositiveSigmaWithAnyLeverArm) {
  Config arm = two_signals();
  arm.camera.lever_arm = {0.1, 0.2, 0.3};
  const Car car(arm, true);
  car.wheel_reads(0, 1000);
  (void)car.tick(0);
  estimator::CameraPose far = seen(50.0, 0, 0);
  car.pipeline->take(far);
  EXPECT_EQ(car.count(camera, Verdict::gated), 1U);
  far.sigma_x = -0.01;
  car.pipeline->take(far);
  far.sigma_x = 0.0;
  // A message that is not a pose does not affect the last pose.
  EXPECT_TRUE(car.rejects(far, 5));
  EXPECT_EQ(car.count(camera, Verdict::non_finite), 2U);
  for (const std::int64_t t : {10, 15}) (void)car.rejects(far, t);
  EXPECT_EQ(car.flag(camera), estimator::SourceFlag::non_finite);
}

TEST(SourceWatch, ReportsARejectedCameraWhileItsClockIsAhead) {
  const Car car(two_signals(), true);
  car.wheel_reads(0, 1000);
  (void)car.tick(0);
  EXPECT_FALSE(car.rejects(seen(0.0, 0, 0, 1.0), 5));
  EXPECT_TRUE(car.rejects(seen(0.0, 200, 7, 1.0), 10));
  EXPECT_EQ(car.count(camera, Verdict::future), 1U);
  EXPECT_FALSE(car.rejects(seen(0.0, 9, 9, 1.0), 15));
}

TEST(SourceWatch, FlagsASourceThatContradictsTheOthers) {
  const Car car;
  const TickRecord* record = nullptr;
  for (std::int64_t k = 0; k < 200; ++k) {
    car.gyro_reads(k * 5, static_cast<std::int16_t>(k % 3), k);  // the gyro has noise
    car.wheel_reads(k * 5, 1500);
    record = &car.tick(k * 5);
  }
  EXPECT_EQ(record->pose.conditions & ODOM_COND_SENSOR_FAULT, 0U);
  EXPECT_NE(record->pose.health >> wheel & 1U, 0U);

  // No 16-bit signal can exceed physical limits here, but the camera can freeze.
  for (std::int64_t k = 200; k < 400; ++k) {
    car.wheel_reads(k * 5, static_cast<std::int16_t>(1500 + k % 3));
    car.pipeline->take(seen(1.0, k * 5 - 30, k * 5));
    record = &car.tick(k * 5);
  }
  EXPECT_NE(record->pose.conditions & ODOM_COND_SENSOR_FAULT, 0U);
  EXPECT_EQ(record->pose.health >> camera & 1U, 0U);
  EXPECT_EQ(record->pose.mode, static_cast<std::uint32_t>(ODOM_DEGRADED));
  EXPECT_EQ(car.flag(camera), estimator::SourceFlag::frozen);
  EXPECT_EQ(car.flag(gyro), estimator::SourceFlag::timed_out);
}

}  // namespace
}  // namespace odomd::daemon::pipeline_test
