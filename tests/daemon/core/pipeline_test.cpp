#include "tests/daemon/core/pipeline_car.hpp"

namespace odomd::daemon::pipeline_test {
namespace {

TEST(Pipeline, DrivesStraightAheadAtTheWheelsSpeed) {
  const Car car;
  const TickRecord* record = nullptr;
  for (std::int64_t t = 0; t <= 1000; t += 5) {
    car.wheel_reads(t, 1500);
    record = &car.tick(t);
  }
  EXPECT_TRUE(record->initialised);
  EXPECT_EQ(record->pose.tick, 200U);
  EXPECT_EQ(record->pose.time_ns, start + 1000 * ms);
  EXPECT_NEAR(record->pose.x, 1.5, 0.01);
  EXPECT_NEAR(record->pose.vx, 1.5, 1e-9);
  EXPECT_EQ(record->details.frames[0], 201U);
  EXPECT_EQ(car.count(wheel, Verdict::fused), 201U);
}

TEST(Pipeline, WaitsForTheCameraToInitialise) {
  Config waiting = two_signals();
  waiting.initial_pose.reset();
  const Car car(waiting, true);
  car.wheel_reads(0, 0);
  EXPECT_EQ(car.tick(0).pose.mode, ODOM_INITIALISING);

  estimator::CameraPose pose = seen(2.0, 0, 5);
  pose.yaw = 0.5;
  car.pipeline->take(pose);
  const TickRecord& record = car.tick(5);
  EXPECT_TRUE(record.initialised);
  EXPECT_NEAR(record.pose.x, 2.0, 1e-9);
  EXPECT_NEAR(record.pose.yaw, 0.5, 1e-9);
  EXPECT_EQ(record.details.camera_messages, 1U);
  EXPECT_EQ(car.count(camera, Verdict::fused), 1U);
}

TEST(Pipeline, CountsInvalidValues) {
  Config odd = two_signals();
  odd.can.bindings[0].valid_when = {{"YawRate", 1.0, can::Comparison::below}};
  const Car car(odd);
  car.wheel_reads(0, 32767);  // the first value, at an end of the range
  car.gyro_reads(0, 1000, 1);
  car.wheel_reads(1, 500);
  EXPECT_EQ(car.tick(5).pose.health, 1U << wheel);
  EXPECT_EQ(car.count(wheel, Verdict::not_valid), 1U);
  EXPECT_EQ(car.count(wheel, Verdict::fused), 1U);
  EXPECT_EQ(car.count(gyro, Verdict::not_valid), 1U);
  EXPECT_EQ(car.count(gyro, Verdict::fused), 0U);
}

TEST(Pipeline, CountsSamplesThatAFullWindowDrops) {
  const Car car(two_signals(estimator::Model::full));
  (void)car.tick(0);
  constexpr std::int64_t flood = 3000;
  for (std::int64_t i = 1; i <= flood; ++i) car.take(257, start + i, 1500, start + 5 * ms);
  (void)car.tick(5);
  EXPECT_EQ(car.count(wheel, Verdict::too_old), flood - 1024);
  EXPECT_EQ(car.count(wheel, Verdict::fused) + car.count(wheel, Verdict::gated), 1024U);
}

TEST(Pipeline, StampsFramesWithoutAUsableStampAtTheDrain) {
  const Car car;
  car.take(257, 0, 1000, start);
  EXPECT_EQ(car.tick(2).details.source_age_ns[wheel], 2 * ms);
  car.take(257, start + 900 * ms, 1000, start + 5 * ms);
  EXPECT_EQ(car.tick(7).details.source_age_ns[wheel], 2 * ms);
  const auto& stamps = car.pipeline->statistics().stamps;
  EXPECT_EQ(stamps[static_cast<std::size_t>(can::StampVerdict::zero)].get(), 1U);
  EXPECT_EQ(stamps[static_cast<std::size_t>(can::StampVerdict::future)].get(), 1U);
}

TEST(Pipeline, TakesFreshSamplesAfterSkippedTicks) {
  const Car car;
  car.wheel_reads(0, 1000);
  (void)car.tick(0);
  car.wheel_reads(99, 2000);
  (void)car.tick(100);
  EXPECT_EQ(car.count(wheel, Verdict::fused), 2U);
}

TEST(Pipeline, CountsTheFramesOfEachBusButNoErrorFrames) {
  const Car car;
  car.pipeline->take({.time_ns = start, .id = 0x7FF, .bus = 1, .length = 2}, start);
  car.pipeline->take({.time_ns = start, .id = 4, .kind = can::FrameKind::error}, start);
  const TickRecord& record = car.tick(0);
  EXPECT_EQ(record.details.frames[0], 0U);
  EXPECT_EQ(record.details.frames[1], 1U);
  const auto& frames = car.pipeline->statistics().frames;
  EXPECT_EQ(frames[static_cast<std::size_t>(can::FrameVerdict::unmapped)].get(), 1U);
}

TEST(Pipeline, ResumesWithCalibrationsAndAnInflatedCovariance) {
  const Car first(two_signals(estimator::Model::full));
  TickRecord last;
  for (std::int64_t k = 0; k <= 600; ++k) {  // at rest, while the gyro reads 20 mrad/s
    first.wheel_reads(k * 5, 0);
    first.gyro_reads(k * 5, 20, k);
    last = first.tick(k * 5);
  }
  EXPECT_NEAR(last.details.gyro_bias, 0.02, 1e-3);
  EXPECT_NE(last.details.calibration_valid & 1U, 0U);
  last.pose.x = last.pose.odom_x = 5.0;
  last.pose.conditions |= ODOM_COND_SENSOR_FAULT;  // a flag is not inherited

  const Car second(two_signals(estimator::Model::full));
  second.pipeline->resume(last.pose, last.details, 100 * ms);
  second.wheel_reads(3105, 1000);
  const TickRecord& record = second.tick(3105);
  EXPECT_TRUE(record.initialised);
  EXPECT_NEAR(record.pose.x, 5.0, 0.2);
  EXPECT_GT(record.pose.covariance[0], last.pose.covariance[0]);
  EXPECT_GT(record.pose.reset_count, last.pose.reset_count);
  EXPECT_NEAR(record.details.gyro_bias, last.details.gyro_bias, 1e-3);
  EXPECT_NE(record.details.calibration_valid & 1U, 0U);
  EXPECT_LT(record.details.calibration_sigma[0], 1.5 * last.details.calibration_sigma[0]);
  EXPECT_EQ(record.pose.conditions & ODOM_COND_SENSOR_FAULT, 0U);
}

}  // namespace
}  // namespace odomd::daemon::pipeline_test
