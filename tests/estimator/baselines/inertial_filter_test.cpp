// Dead reckoning from gyro, wheels and the slip of a steady turn.
#include "estimator/baselines/motion.hpp"
#include "estimator/common/pose.hpp"
#include "tests/estimator/drive.hpp"
#include "tests/gtest.hpp"

namespace odomd::estimator::testing::inertial_filter_test {
namespace {

const Vehicle car;

TEST(InertialFilter, DrivesTheCircleThatItsSlipMakes) {
  const double v_x = 2.0;
  const double yaw_rate = 0.8;
  const double v_y = 0.085 * yaw_rate -
                     v_x * v_x * yaw_rate * 0.175 * 2.985 / (0.26 * 60.0);  // of the default car
  const double radius = std::hypot(v_x, v_y) / yaw_rate;
  Drive drive = start(Model::inertial);
  drive.tick({.speed = v_x, .yaw_rate = yaw_rate});
  // The centre lies abeam of the velocity: at (-v_y, v_x) / ψ̇.
  for (int i = 0; i < 1000; ++i) {
    const Estimate e = drive.tick({.speed = v_x, .yaw_rate = yaw_rate});
    EXPECT_NEAR(e.v_y, v_y, 1e-15);
    EXPECT_NEAR(std::hypot(e.map.x + v_y / yaw_rate, e.map.y - v_x / yaw_rate), radius, 1e-12);
  }
  EXPECT_NEAR(drive.last.map.yaw, 5.0 * yaw_rate, 1e-12);
}

TEST(InertialFilter, HeadingIsTheIntegralOfTheGyroWhateverTheSteering) {
  Drive drive = start(Model::inertial);
  drive.tick({.speed = 1.0, .steering = -0.3, .yaw_rate = 0.0});
  double heading = 0.0;
  for (int i = 1; i <= 2000; ++i) {
    const double rate = 1.5 * std::sin(0.01 * i);
    heading += 0.005 * rate;
    drive.tick({.speed = 1.0, .steering = -0.3, .yaw_rate = rate});
  }
  EXPECT_NEAR(drive.last.map.yaw, heading, 1e-12);
}

TEST(InertialFilter, FrontWheelsAreTakenToTheRearAxle) {
  const double yaw_rate = 0.6;
  const double delta = 0.2;
  Drive drive = start(Model::inertial);
  for (int i = 0; i < 10; ++i) {
    const std::int64_t now = drive.now_ns + testing::period_ns;
    add(drive.filter, Measurement{Source::wheel_front_left, now,
                                  (1.0 - yaw_rate * car.track_width / 2.0) / std::cos(delta), 0.0});
    drive.tick({.steering = delta, .yaw_rate = yaw_rate});
  }
  EXPECT_NEAR(drive.last.v_x, 1.0, 1e-12);
}

TEST(InertialFilter, IgnoresTheLateralAccelerometer) {
  Drive drive = start(Model::inertial);
  EXPECT_EQ(add(drive.filter, Measurement{Source::accel_y, 1, 1.0, 0.1}), Verdict::source_off);
  EXPECT_EQ(add(drive.filter, Measurement{Source::yaw_rate, 1, 1.0, 0.1}), Verdict::fused);
  EXPECT_EQ(add(drive.filter, Measurement{Source::wheel_rear, 1, 1.0, 0.1}), Verdict::fused);
}

TEST(InertialFilter, AccelerationFollowsTheAccelerometerWithTheYawRateHeld) {
  Drive drive = start(Model::inertial);
  EXPECT_EQ(drive.tick({.speed = 2.0, .yaw_rate = 0.5}).v_x_dot, 0.0);
  const Estimate e = drive.tick({.speed = 2.0, .yaw_rate = 0.5, .accel_x = 0.5});
  EXPECT_DOUBLE_EQ(e.v_x_dot, 0.5 + e.v_y * e.yaw_rate);
  EXPECT_EQ(e.yaw_accel, 0.0);
  constexpr double step = 1e-6;
  const double ahead = reckon(Model::inertial, car, 2.0 + e.v_x_dot * step, 0.5).velocity.v_y;
  EXPECT_NEAR(e.v_y_dot, (ahead - e.v_y) / step, 1e-5);
}

/// Settings for sensors without lasting errors.
FilterSettings calibrated() {
  FilterSettings settings;
  settings.tuning.gyro_bias = settings.tuning.gyro_scale = settings.tuning.wheel_scale = 0.0;
  return settings;
}

TEST(InertialFilter, CovarianceComesFromTheSigmasOfTheSamples) {
  const auto yaw_sigma_after = [](double sigma_yaw_rate) {
    Drive drive = start(Model::inertial, calibrated());
    for (int i = 0; i < 1000; ++i) {
      add(drive.filter, Measurement{Source::yaw_rate, drive.now_ns + 1, 0.0, sigma_yaw_rate});
      drive.tick({.speed = 2.0});
    }
    return std::sqrt(drive.last.covariance[5] - 0.05 * 0.05);
  };
  // σ_ψ = √n Δt σ_ψ̇
  const double expected = std::sqrt(1000.0) * 0.005 * 0.1;
  EXPECT_NEAR(yaw_sigma_after(0.1), expected, 0.01 * expected);
  EXPECT_NEAR(yaw_sigma_after(0.2), 2.0 * expected, 0.01 * expected);
}

/// Ten seconds of turns in both directions, whose readings have lasting errors.
Estimate turns(const FilterSettings& settings, double bias, double gyro_scale, double wheel_scale) {
  Drive drive = start(Model::inertial, settings, Pose2{1.0, 2.0, 0.5});
  for (int i = 0; i < 2000; ++i) {
    const double speed = 1.0 + 0.5 * std::sin(0.01 * i);
    const double yaw_rate = 0.4 + std::cos(0.005 * i);
    drive.tick(
        {.speed = (1.0 + wheel_scale) * speed, .yaw_rate = (1.0 + gyro_scale) * yaw_rate + bias});
  }
  return drive.last;
}

TEST(InertialFilter, CovarianceHasWhatLastingErrorsDoToThePose) {
  constexpr double small = 1e-5;
  const Estimate base = turns(calibrated(), 0.0, 0.0, 0.0);
  for (const std::size_t error : {0U, 1U, 2U}) {
    SCOPED_TRACE(error);
    FilterSettings settings = calibrated();
    double* const sigma = std::array{&settings.tuning.gyro_bias, &settings.tuning.gyro_scale,
                                     &settings.tuning.wheel_scale}[error];
    *sigma = 0.01;
    const Estimate considered = turns(settings, 0.0, 0.0, 0.0);
    EXPECT_EQ(considered.map.x, base.map.x);
    const Estimate off = turns(settings, error == 0 ? small : 0.0, error == 1 ? small : 0.0,
                               error == 2 ? small : 0.0);
    const std::array<double, 3> by = difference(off.map, base.map);
    std::size_t k = 0;
    for (std::size_t i = 0; i < 3; ++i) {
      for (std::size_t j = i; j < 3; ++j, ++k) {
        const double expected = by[i] * by[j] * 0.01 * 0.01 / (small * small);
        EXPECT_NEAR(considered.covariance[k] - base.covariance[k], expected,
                    1e-6 + 0.02 * std::abs(expected));
      }
    }
  }
}

TEST(InertialFilter, CameraEndsWhatLastingErrorsHaveDone) {
  Drive drive = start(Model::inertial);
  drive.ticks(4000, {.speed = 1.0, .yaw_rate = 0.5});
  EXPECT_GT(drive.last.covariance[5], 0.3);
  // The camera sees the car as it was 20 ticks ago.
  const std::int64_t capture_ns = drive.now_ns;
  const Estimate before = drive.last;
  drive.ticks(20, {.speed = 1.0, .yaw_rate = 0.5});
  EXPECT_EQ(add(drive.filter, CameraPose{.capture_ns = capture_ns,
                                         .arrival_ns = drive.now_ns,
                                         .x = before.map.x,
                                         .y = before.map.y,
                                         .yaw = before.map.yaw,
                                         .sigma_x = 0.02,
                                         .sigma_y = 0.02,
                                         .sigma_yaw = 0.02}),
            Verdict::fused);
  const Estimate e = drive.tick({.speed = 1.0, .yaw_rate = 0.5});
  // R, 21 ticks of noise, and the errors of bias and scale
  const double t = 21 * 0.005;
  const double expected = 4e-4 + 21 * 25e-6 * 9e-4 + std::pow(0.03 * t, 2) + std::pow(0.01 * t, 2);
  EXPECT_NEAR(e.covariance[5], expected, 0.01 * expected);
}

TEST(InertialFilter, AveragesTheGyroAtRest) {
  Drive drive = start(Model::inertial);
  drive.ticks(2000, {.speed = 0.0, .yaw_rate = 0.02});
  const Estimate rest = drive.last;
  EXPECT_NEAR(rest.yaw_rate, 0.0, 1e-4);
  // The whole turn integrated until then is within two sigmas.
  EXPECT_LT(rest.map.yaw, 2.0 * std::sqrt(rest.covariance[5]));
  const Estimate e = drive.ticks(2000, {.speed = 1.0, .yaw_rate = 0.02});
  EXPECT_NEAR(e.map.yaw, rest.map.yaw, 1e-3);
  // P_b = σ² / n after n samples; the turn at rest has the same error.
  const double bias = 9e-4 / 1830.0;
  const double expected = (20.0 * 20.0 - 10.0 * 10.0) * bias + 2000 * 25e-6 * 9e-4;
  EXPECT_NEAR(e.covariance[5] - rest.covariance[5], expected, 0.1 * expected);
}

TEST(InertialFilter, StretchAtRestCountsByItsLength) {
  const auto after_rest_of = [](int ticks, double reading) {
    Drive drive = start(Model::inertial);
    drive.ticks(2000, {.speed = 0.0, .yaw_rate = 0.0});
    drive.ticks(200, {.speed = 1.0, .yaw_rate = 0.0});
    drive.ticks(ticks, {.speed = 0.0, .yaw_rate = reading});
    return -drive.tick({.speed = 1.0, .yaw_rate = 0.0}).yaw_rate;
  };
  EXPECT_EQ(after_rest_of(170, 0.1), 0.0);   // the rest is too short
  EXPECT_EQ(after_rest_of(2000, 0.2), 0.0);  // the car turns
  EXPECT_NEAR(after_rest_of(250, 0.1), 0.1 * 122.0 / 1952.0, 5e-4);
}

}  // namespace
}  // namespace odomd::estimator::testing::inertial_filter_test
