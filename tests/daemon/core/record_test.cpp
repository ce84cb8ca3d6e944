#include "daemon/core/record.hpp"
#include "tests/gtest.hpp"

namespace odomd::daemon::record_test {
namespace {

using estimator::Estimate;
using estimator::Mode;

TEST(PublishedMode, FollowsThePrecedence) {
  Estimate estimate;
  estimate.initialised = true;
  estimate.mode = Mode::tracking;
  EXPECT_EQ(published_mode(estimate, 0), ODOM_TRACKING);
  for (const std::uint32_t harmless :
       {ODOM_COND_CAMERA_REJECTED, ODOM_COND_BIAS_UNLEARNT, ODOM_COND_SCALE_IMPLAUSIBLE})
    EXPECT_EQ(published_mode(estimate, harmless), ODOM_TRACKING);
  estimate.mode = Mode::standstill;
  EXPECT_EQ(published_mode(estimate, 0), ODOM_STANDSTILL);
  EXPECT_EQ(published_mode(estimate, ODOM_COND_NOT_REALTIME), ODOM_DEGRADED);
  estimate.initialised = false;
  EXPECT_EQ(published_mode(estimate, ODOM_COND_NOT_REALTIME), ODOM_INITIALISING);
  estimate.model_fault = true;
  EXPECT_EQ(published_mode(estimate, ODOM_COND_NOT_REALTIME), ODOM_FAULT);
}

TEST(Conditions, AreThoseThatTheEstimateStates) {
  Estimate estimate;
  EXPECT_EQ(estimator_conditions(estimate), 0U);
  estimate.bias_unlearnt = true;
  EXPECT_EQ(estimator_conditions(estimate), ODOM_COND_BIAS_UNLEARNT);
  estimate.scale_implausible = true;
  EXPECT_EQ(estimator_conditions(estimate), ODOM_COND_BIAS_UNLEARNT | ODOM_COND_SCALE_IMPLAUSIBLE);
  estimate = {};
  estimate.doubtful = true;
  estimate.model_fault = true;
  EXPECT_EQ(estimator_conditions(estimate), ODOM_COND_SENSOR_FAULT | ODOM_COND_MODEL_FAULT);
}

Estimate some_estimate() {
  Estimate estimate;
  estimate.time_ns = 12'345;
  estimate.initialised = true;
  estimate.mode = Mode::dead_reckoning;
  estimate.map = {3.0, -2.0, 1.2};
  estimate.odom = {1.0, 0.5, -0.3};
  estimate.v_x = 1.5;
  estimate.v_y = -0.02;
  estimate.yaw_rate = 0.7;
  estimate.covariance = {1, 2, 3, 4, 5, 6};
  estimate.cross_covariance = {21, 22, 23, 24, 25, 26, 27, 28, 29};
  estimate.velocity_covariance = {7, 8, 9, 10, 11, 12};
  estimate.calibration = {
      .value = {0.01, 1.02, 0.3, -0.4, 0.99, -0.02, 1.1, 0.012, -0.003, 0.04, 8.5},
      .sigma = {0.001, 0.002, 0.003, 0.004, 0.005, 0.006, 0.007, 0.008, 0.009, 0.010, 0.011},
      .valid = 0b10101010011};
  estimate.reset_count = 3;
  estimate.last_jump = {0.1, 0.2, 0.3};
  estimate.camera_ns = 999;
  return estimate;
}

TEST(Record, CorrectionTakesTheOdometryPoseToTheMapPose) {
  TickRecord record;
  fill_record(some_estimate(), record);
  const odom_details& d = record.details;
  const odom_pose& p = record.pose;
  const double c = std::cos(d.correction_yaw);
  const double s = std::sin(d.correction_yaw);
  EXPECT_NEAR(d.correction_x + c * p.odom_x - s * p.odom_y, p.x, 1e-12);
  EXPECT_NEAR(d.correction_y + s * p.odom_x + c * p.odom_y, p.y, 1e-12);
  EXPECT_NEAR(d.correction_yaw + p.odom_yaw, p.yaw, 1e-12);
}

TEST(Record, PacksTheRestOfTheUpperTriangleByRows) {
  TickRecord record;
  fill_record(some_estimate(), record);
  for (int i = 0; i < 9; ++i) EXPECT_EQ(record.details.velocity_covariance[i], 21.0 + i) << i;
  for (int i = 0; i < 6; ++i) EXPECT_EQ(record.details.velocity_covariance[9 + i], 7.0 + i) << i;
}

TEST(Record, CarriesTheCalibrations) {
  TickRecord record;
  fill_record(some_estimate(), record);
  const odom_details& d = record.details;
  EXPECT_THAT((std::array{d.gyro_bias, d.gyro_scale, d.accel_bias_x, d.accel_bias_y, d.wheel_scale,
                          d.steering_offset, d.stiffness_scale, d.gyro_latency, d.wheel_latency,
                          d.steering_latency, d.grip}),
              testing::ElementsAreArray(some_estimate().calibration.value));
  for (int i = 0; i < 7; ++i) EXPECT_EQ(d.calibration_sigma[i], 0.001 * (i + 1)) << i;
  for (std::size_t i = 0; i < 4; ++i)
    EXPECT_EQ(d.further_calibration_sigma[i], some_estimate().calibration.sigma[7 + i]) << i;
  for (std::size_t i = 0; i < calibrations.size(); ++i)
    EXPECT_EQ(calibration_sigma(d, i), some_estimate().calibration.sigma[i]) << i;
  EXPECT_EQ(d.calibration_valid, 0b10101010011U);
}

TEST(Record, SaysOfAModelThatLearnsNothingThatAllIsExactAndNothingKnown) {
  TickRecord record;
  fill_record(Estimate{}, record);
  const odom_details& d = record.details;
  EXPECT_THAT((std::array{d.gyro_bias, d.gyro_scale, d.wheel_scale, d.stiffness_scale,
                          d.steering_latency, d.grip}),
              ElementsAre(0.0, 1.0, 1.0, 1.0, 0.0, 0.0));
  EXPECT_EQ(d.calibration_valid, 0U);
}

TEST(Record, AnEstimateSurvivesTheWayThereAndBack) {
  const Estimate before = some_estimate();
  TickRecord record;
  fill_record(before, record);
  record.pose.mode = ODOM_DEAD_RECKONING;
  const Estimate after = to_estimate(record.pose, record.details);
  EXPECT_EQ(after.time_ns, before.time_ns);
  EXPECT_TRUE(after.initialised);
  EXPECT_EQ(after.map.x, before.map.x);
  EXPECT_EQ(after.odom.yaw, before.odom.yaw);
  EXPECT_EQ(after.v_y, before.v_y);
  EXPECT_EQ(after.covariance, before.covariance);
  EXPECT_EQ(after.velocity_covariance, before.velocity_covariance);
  EXPECT_EQ(after.cross_covariance, before.cross_covariance);
  EXPECT_EQ(after.calibration.value, before.calibration.value);
  EXPECT_EQ(after.calibration.sigma, before.calibration.sigma);
  EXPECT_EQ(after.calibration.valid, before.calibration.valid);
  EXPECT_EQ(after.reset_count, before.reset_count);
  EXPECT_EQ(after.camera_ns, before.camera_ns);
}

TEST(Record, AnInitialisingPredecessorHasNoPoseToGoOnFrom) {
  odom_pose pose{};
  pose.mode = ODOM_INITIALISING;
  EXPECT_FALSE(to_estimate(pose, odom_details{}).initialised);
}

TEST(Record, APredecessorInFaultHasAFrozenPoseNotToGoOnFrom) {
  odom_pose pose{};
  pose.mode = ODOM_FAULT;
  EXPECT_TRUE(to_estimate(pose, odom_details{}).model_fault);
}

}  // namespace
}  // namespace odomd::daemon::record_test
