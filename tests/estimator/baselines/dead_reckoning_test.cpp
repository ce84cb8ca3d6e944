// Dead reckoning with the kinematic bicycle (steering and wheels) and with the slip odometer (gyro,
// wheels, slip of a steady turn): geometry, forces, Jacobians compared with automatic
// differentiation, and the filters.
#include "estimator/baselines/motion.hpp"

#include <tuple>

#include "estimator/common/pose.hpp"
#include "tests/estimator/autodiff.hpp"
#include "tests/estimator/drive.hpp"

namespace odomd::estimator::testing::dead_reckoning_test {
namespace {

const Vehicle car;
constexpr std::array kinematic_models{Model::kinematic, Model::kinematic_printed};

DeadReckoning inertial(double v_x, double yaw_rate) {
  return reckon(Model::inertial, car, v_x, yaw_rate);
}

TEST(Kinematic, VelocityAndJacobianMatchTheModel) {
  // The same model, for automatic differentiation.
  const auto velocity = [](double lever, const Eigen::Matrix<Dual<2>, 2, 1>& input) {
    const Dual<2> yaw_rate = input[0] / car.wheelbase() * tan(input[1]);
    return Eigen::Matrix<Dual<2>, 3, 1>{input[0], lever * yaw_rate, yaw_rate};
  };
  for (const Model model : kinematic_models) {
    const double lever = model == Model::kinematic ? car.rear_axle : 0.0;
    for (const double v_x : {-2.0, 0.0, 0.01, 1.0, 30.0}) {
      for (const double delta : {-0.6, -0.1, 0.0, 0.3, 0.6}) {
        const auto expected = velocity(lever, variables<2, 2>(Eigen::Vector2d{v_x, delta}, 0));
        const DeadReckoning now = reckon(model, car, v_x, delta);
        EXPECT_EQ(now.velocity.v_x, v_x);
        EXPECT_DOUBLE_EQ(now.velocity.v_y, expected[1].value());
        EXPECT_DOUBLE_EQ(now.velocity.yaw_rate, expected[2].value());
        EXPECT_LT((now.jacobian - jacobian<2>(expected)).cwiseAbs().maxCoeff(),
                  1e-12 * (1.0 + std::abs(v_x)))
            << v_x << " " << delta;
      }
    }
  }
}

TEST(Inertial, RearAxleCarriesItsShareOfTheLateralForceInASteadyTurn) {
  for (const double v_x : {2.0, -2.0}) {
    for (const double yaw_rate : {0.7, -0.7}) {
      const BodyVelocity v = inertial(v_x, yaw_rate).velocity;
      // If the front wheels roll along their own direction, α_v = 0, only the rear axle turns the
      // car.
      const double delta = (v.v_y + car.front_axle * v.yaw_rate) / v.v_x;
      const double yaw_accel = dynamic_rate(car, v, delta, 0.0, 0.1).yaw_rate;
      const double rear_force = -yaw_accel * car.yaw_inertia / car.rear_axle;
      EXPECT_NEAR(rear_force, car.front_axle / car.wheelbase() * car.mass * v_x * yaw_rate, 1e-12);
    }
  }
}

TEST(Inertial, JacobianMatchesDifferencesOfTheVelocity) {
  constexpr double step = 1e-6;
  const auto v_y = [](double v_x, double yaw_rate) { return inertial(v_x, yaw_rate).velocity.v_y; };
  for (const double v : {-2.0, 0.4, 3.0}) {
    for (const double r : {-1.2, 0.0, 0.9}) {
      const auto j = inertial(v, r).jacobian;
      EXPECT_NEAR(j(1, 0), (v_y(v + step, r) - v_y(v - step, r)) / (2.0 * step), 1e-8);
      EXPECT_NEAR(j(1, 1), (v_y(v, r + step) - v_y(v, r - step)) / (2.0 * step), 1e-8);
      EXPECT_EQ(j(0, 0), 1.0);
      EXPECT_EQ(j(2, 1), 1.0);
    }
  }
}

// The filters
// --------------------------------------------------------------------------------------

TEST(DeadReckoningFilter, CentreOfGravityDrivesItsCircle) {
  // On a circle the slip of the default car's rear tyres reduces v_y = l_h ψ̇ by
  // v_x² ψ̇ l_v m / (l C_h); as printed, the kinematic model has no v_y.
  const double delta = 0.3;
  const double turn = std::tan(delta) / car.wheelbase();
  const double slipping = 0.085 * 0.8 - 2.0 * 2.0 * 0.8 * 0.175 * 2.985 / (0.26 * 60.0);
  struct Circle {
    Model model;
    Samples samples;
    double yaw_rate;
    double v_y;
  };
  for (const auto& [model, samples, yaw_rate, v_y] :
       {Circle{Model::kinematic, {.speed = 1.0, .steering = delta}, turn, car.rear_axle * turn},
        {Model::kinematic_printed, {.speed = 1.0, .steering = delta}, turn, 0.0},
        {Model::inertial, {.speed = 2.0, .yaw_rate = 0.8}, 0.8, slipping}}) {
    SCOPED_TRACE(model_names[static_cast<std::size_t>(model)]);
    const double v_x = *samples.speed;
    Drive drive = start(model);
    drive.tick(samples);
    // The centre is perpendicular to the velocity: at (-v_y, v_x) / ψ̇.
    for (int i = 0; i < 1000; ++i) {
      const Pose2 map = drive.tick(samples).map;
      EXPECT_NEAR(drive.last.v_y, v_y, 1e-15);
      EXPECT_NEAR(std::hypot(map.x + v_y / yaw_rate, map.y - v_x / yaw_rate),
                  std::hypot(v_x, v_y) / yaw_rate, 1e-12);
    }
    EXPECT_NEAR(drive.last.map.yaw, 5.0 * yaw_rate, 1e-12);
  }
}

TEST(KinematicFilter, ReversesOnTheSameCircle) {
  Drive drive = start(Model::kinematic);
  drive.ticks(1, {.speed = 0.0, .steering = 0.4});
  drive.ticks(200, {.speed = 0.8, .steering = 0.4});
  drive.ticks(200, {.speed = -0.8, .steering = 0.4});
  // The speed is a ramp between ticks, so one more tick completes the two half ticks at start and
  // turn.
  EXPECT_THAT(drive.tick({.speed = 0.0, .steering = 0.4}).map, PoseNear({}, 1e-12));
}

TEST(KinematicFilter, SingleRearWheelDrivesTheSameCircleAsTheAxle) {
  const double delta = 0.3;
  const double yaw_rate = std::tan(delta) / car.wheelbase();
  Drive axle = start(Model::kinematic);
  Drive wheel = start(Model::kinematic);
  for (int i = 0; i < 2000; ++i) {
    axle.tick({.speed = 1.0, .steering = delta});
    wheel.send(Source::wheel_rear_left, 1.0 - yaw_rate * car.track_width / 2.0, 0.05);
    wheel.tick({.steering = delta});
  }
  // A wheel is corrected with the yaw rate of the previous tick, so it settles within a few ticks.
  EXPECT_NEAR(wheel.last.v_x, 1.0, 1e-12);
  EXPECT_NEAR(wheel.last.map.yaw, axle.last.map.yaw, 0.005);
}

TEST(KinematicFilter, AccelerationFollowsTheAccelerometer) {
  const double delta = 0.2;
  Drive drive = start(Model::kinematic);
  EXPECT_EQ(drive.tick({.speed = 1.0, .steering = delta}).v_x_dot, 0.0);
  const Estimate e = drive.tick({.speed = 1.0, .steering = delta, .accel_x = 0.5});
  EXPECT_DOUBLE_EQ(e.v_x_dot, 0.5 + e.v_y * e.yaw_rate);
  EXPECT_DOUBLE_EQ(e.yaw_accel, e.v_x_dot * std::tan(delta) / car.wheelbase());
  EXPECT_DOUBLE_EQ(e.v_y_dot, car.rear_axle * e.yaw_accel);
  EXPECT_EQ(e.accel_x, 0.5);
  EXPECT_EQ(e.steering, delta);
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

TEST(InertialFilter, FrontWheelSpeedIsReferredToTheRearAxle) {
  const double yaw_rate = 0.6;
  const double delta = 0.2;
  Drive drive = start(Model::inertial);
  for (int i = 0; i < 10; ++i) {
    const double rear_left = 1.0 - yaw_rate * car.track_width / 2.0;
    drive.send(Source::wheel_front_left, rear_left / std::cos(delta));
    drive.tick({.steering = delta, .yaw_rate = yaw_rate});
  }
  EXPECT_NEAR(drive.last.v_x, 1.0, 1e-12);
}

TEST(DeadReckoningFilter, UsesOnlyTheSourcesOfItsModel) {
  for (const auto& [model, used, ignored] :
       {std::tuple{Model::kinematic, Source::steering, Source::yaw_rate},
        {Model::kinematic, Source::wheel_rear, Source::accel_y},
        {Model::inertial, Source::yaw_rate, Source::accel_y},
        {Model::inertial, Source::wheel_rear, Source::accel_y}}) {
    Drive drive = start(model);
    EXPECT_EQ(drive.send(ignored, 0.1), Verdict::source_off);
    EXPECT_EQ(drive.send(used, 0.1), Verdict::fused);
  }
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

TEST(DeadReckoningFilter, CovarianceComesFromTheSigmasOfTheSamples) {
  // σ_ψ = √n Δt σ_ψ̇; for the kinematic model straight ahead, σ_ψ̇ = v_x / l σ_δ
  for (const auto& [model, source, sigma, sigma_yaw_rate] :
       {std::tuple{Model::kinematic, Source::steering, 0.02, 2.0 / car.wheelbase() * 0.02},
        {Model::inertial, Source::yaw_rate, 0.1, 0.1}}) {
    const double expected = std::sqrt(1000.0) * 0.005 * sigma_yaw_rate;
    for (const double times : {1.0, 2.0}) {
      Drive drive = start(model, calibrated());
      for (int i = 0; i < 1000; ++i) {
        drive.send(source, 0.0, times * sigma);
        drive.tick({.speed = 2.0});
      }
      EXPECT_NEAR(std::sqrt(drive.last.covariance[5] - 0.05 * 0.05), times * expected,
                  0.01 * expected);
    }
  }
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

TEST(InertialFilter, CovarianceIncludesTheEffectOfLastingErrors) {
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

TEST(InertialFilter, CameraRemovesTheEffectOfLastingErrors) {
  Drive drive = start(Model::inertial);
  drive.ticks(4000, {.speed = 1.0, .yaw_rate = 0.5});
  EXPECT_GT(drive.last.covariance[5], 0.3);
  // The camera sees the car as it was 20 ticks ago.
  const Pose2 before = drive.last.map;
  drive.ticks(20, {.speed = 1.0, .yaw_rate = 0.5});
  EXPECT_EQ(drive.see(before, 0.02, 0.02, 21 * period_ns), Verdict::fused);
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

TEST(InertialFilter, RestIsWeightedByItsDuration) {
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
}  // namespace odomd::estimator::testing::dead_reckoning_test
