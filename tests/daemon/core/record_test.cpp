#include "daemon/core/record.hpp"

#include <tuple>

#include "tests/gtest.hpp"

namespace odomd::daemon::record_test {
namespace {

using estimator::Estimate;
using estimator::Mode;
using testing::ElementsAreArray;

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

TEST(Conditions, FollowFromTheEstimate) {
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

/// The published record of an estimate.
TickRecord record_of(const Estimate& estimate) {
  TickRecord record;
  fill_record(estimate, record);
  return record;
}

TEST(Record, CorrectionMapsTheOdometryPoseToTheMapPose) {
  const auto [p, d, initialised] = record_of(some_estimate());
  const double c = std::cos(d.correction_yaw);
  const double s = std::sin(d.correction_yaw);
  EXPECT_NEAR(d.correction_x + c * p.odom_x - s * p.odom_y, p.x, 1e-12);
  EXPECT_NEAR(d.correction_y + s * p.odom_x + c * p.odom_y, p.y, 1e-12);
  EXPECT_NEAR(d.correction_yaw + p.odom_yaw, p.yaw, 1e-12);
}

TEST(Record, PacksTheRestOfTheUpperTriangleByRows) {
  EXPECT_THAT(record_of(some_estimate()).details.velocity_covariance,
              ElementsAre(21, 22, 23, 24, 25, 26, 27, 28, 29, 7, 8, 9, 10, 11, 12));
}

TEST(Record, CarriesTheCalibrations) {
  const odom_details d = record_of(some_estimate()).details;
  EXPECT_THAT((std::array{d.gyro_bias, d.gyro_scale, d.accel_bias_x, d.accel_bias_y, d.wheel_scale,
                          d.steering_offset, d.stiffness_scale, d.gyro_latency, d.wheel_latency,
                          d.steering_latency, d.grip}),
              ElementsAreArray(some_estimate().calibration.value));
  EXPECT_THAT(d.calibration_sigma, ElementsAre(0.001, 0.002, 0.003, 0.004, 0.005, 0.006, 0.007));
  EXPECT_THAT(d.further_calibration_sigma, ElementsAre(0.008, 0.009, 0.010, 0.011));
  EXPECT_EQ(d.calibration_valid, 0b10101010011U);
}

TEST(Record, ModelWithoutCalibrationsPublishesNeutralValues) {
  const odom_details d = record_of(Estimate{}).details;
  EXPECT_THAT((std::array{d.gyro_bias, d.gyro_scale, d.wheel_scale, d.stiffness_scale,
                          d.steering_latency, d.grip}),
              ElementsAre(0.0, 1.0, 1.0, 1.0, 0.0, 0.0));
  EXPECT_EQ(d.calibration_valid, 0U);
}

auto values(const Estimate& e) {
  const std::array numbers{e.map.x,    e.map.y,       e.map.yaw,     e.odom.x,
                           e.odom.y,   e.odom.yaw,    e.v_x,         e.v_y,
                           e.yaw_rate, e.last_jump.x, e.last_jump.y, e.last_jump.yaw};
  return std::tuple{numbers,
                    e.time_ns,
                    e.initialised,
                    e.covariance,
                    e.cross_covariance,
                    e.velocity_covariance,
                    e.calibration.value,
                    e.calibration.sigma,
                    e.calibration.valid,
                    e.reset_count,
                    e.camera_ns};
}

TEST(Record, EstimateSurvivesARoundTrip) {
  TickRecord record = record_of(some_estimate());
  record.pose.mode = ODOM_DEAD_RECKONING;
  EXPECT_EQ(values(to_estimate(record.pose, record.details)), values(some_estimate()));
}

TEST(Record, DoesNotResumeFromInitialisingOrFault) {
  odom_pose pose{};
  pose.mode = ODOM_INITIALISING;
  EXPECT_FALSE(to_estimate(pose, odom_details{}).initialised);
  pose.mode = ODOM_FAULT;
  EXPECT_TRUE(to_estimate(pose, odom_details{}).model_fault);
}

}  // namespace
}  // namespace odomd::daemon::record_test
