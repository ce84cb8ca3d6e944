// Errors that last: sensors that are later than configured, and a camera whose errors are not
// white.
#include <random>

#include <Eigen/LU>

#include "estimator/common/pose.hpp"
#include "estimator/common/symmetric3.hpp"
#include "tests/estimator/drive.hpp"

namespace odomd::estimator::testing::lasting_errors_test {
namespace {

constexpr double period_s = 0.005;

struct Errors {
  double gyro_latency_s = 0.0;
  double wheel_latency_s = 0.0;
  double steering_latency_s = 0.0;
  double camera_lasting = 0.0;    ///< sigma of x and y [m]; of the yaw: half of that [rad]
  double camera_lasting_s = 3.0;  ///< correlation time of that error
  double jump = 0.0;              ///< jump of the camera's map along x, after 30 s [m]
  double turn = 0.0;              ///< jump of its yaw [rad]
  double camera_sigma = 0.008;    ///< as stated [m]
};

struct Outcome {
  double nees = 0.0;     ///< mean NEES of the second half
  double off = 0.0;      ///< rms position error of the second half [m]
  double sigma_x = 0.0;  ///< at the end
  Calibration calibration;
  double silent_s = 0.0;  ///< time with an error beyond five sigmas that is not `doubtful` [s]
};

double speed_at(double t) {
  return t < 2.0
             ? 0.0
             : 1.5 - 1.5 * std::exp(2.0 - t) + 0.3 * std::sin(1.7 * t) * (1.0 - std::exp(2.0 - t));
}
double turn_at(double t) {
  return t < 2.0 ? 0.0 : 1.2 * std::sin(2.1 * (t - 2.0)) * (1.0 - std::exp(2.0 - t));
}

/// A minute of a car of the default size on stiff tyres: its rear axle follows its heading.
Outcome drive(const Errors& errors, unsigned seed) {
  FilterSettings settings;
  settings.vehicle.cornering_stiffness_front = 2000.0;
  settings.vehicle.cornering_stiffness_rear = 2000.0;
  const double rear = settings.vehicle.rear_axle;
  settings.tuning.camera_latency = 0.0;  // the camera's clock is exact
  Drive car = start(Model::full, settings);
  std::mt19937 random(seed);
  std::normal_distribution<double> normal;
  std::array<double, 3> lasting{};
  for (double& error : lasting) error = errors.camera_lasting * normal(random);
  Pose2 truth;
  Outcome outcome;
  constexpr int ticks = 12'000;
  for (int k = 1; k <= ticks; ++k) {
    const double t = k * period_s;
    const double middle = t - 0.5 * period_s;
    truth = moved(truth, {speed_at(middle), rear * turn_at(middle), turn_at(middle)}, period_s);
    const auto send = [&](Source source, double value, double sigma) {
      car.send(source, value + sigma * normal(random), sigma);
    };
    const double steered = t - errors.steering_latency_s;
    const double v = speed_at(steered);
    send(Source::steering,
         v > 0.05 ? std::atan(settings.vehicle.wheelbase() * turn_at(steered) / v) : 0.0, 0.002);
    send(Source::yaw_rate, turn_at(t - errors.gyro_latency_s), 0.01);
    if (k % 2 == 0) send(Source::wheel_rear, speed_at(t - errors.wheel_latency_s), 0.01);
    if (k % 7 == 0) {
      const double fades = std::exp(-7.0 * period_s / errors.camera_lasting_s);
      for (double& error : lasting) {
        error =
            fades * error + std::sqrt(1.0 - fades * fades) * errors.camera_lasting * normal(random);
      }
      const double jump = t < 30.0 ? 0.0 : errors.jump;
      const double turn = t < 30.0 ? 0.0 : errors.turn;
      const Pose2 seen{truth.x + jump + lasting[0] + 0.008 * normal(random),
                       truth.y + lasting[1] + 0.008 * normal(random),
                       truth.yaw + turn + 0.5 * lasting[2] + 0.01 * normal(random)};
      car.see(seen, errors.camera_sigma, 1.25 * errors.camera_sigma);
    }
    const Estimate e = car.tick();
    outcome.calibration = e.calibration;
    outcome.sigma_x = std::sqrt(e.covariance[0]);
    const Eigen::Vector3d off(difference(e.map, truth).data());
    const Eigen::Matrix3d P = unpacked(e.covariance);
    const bool beyond = off.head<2>().norm() > 5.0 * std::sqrt(P(0, 0) + P(1, 1)) ||
                        std::abs(off[2]) > 5.0 * std::sqrt(P(2, 2));
    outcome.silent_s += beyond && !e.doubtful ? period_s : 0.0;
    if (k > ticks / 2) {
      outcome.nees += off.dot(P.inverse() * off) / (ticks / 2);
      outcome.off += off.head<2>().squaredNorm() / (ticks / 2);
    }
  }
  outcome.off = std::sqrt(outcome.off);
  return outcome;
}

/// In the order of Calibration.
constexpr std::size_t gyro_latency = 7;
constexpr std::size_t wheel_latency = 8;
constexpr std::size_t steering_latency = 9;

TEST(LastingErrors, WithoutThemTheCovarianceIsConsistent) {
  const Outcome outcome = drive({}, 1);
  EXPECT_LT(outcome.off, 0.006);
  EXPECT_GT(outcome.nees, 0.5);
  EXPECT_LT(outcome.nees, 6.0);
}

TEST(LastingErrors, LatenciesBeyondTheConfiguredAreLearnt) {
  struct Late {
    Errors errors;
    std::size_t calibration;
    double latency_s;
    double tolerance_s;
    double off;
    unsigned seed;
  };
  for (const auto& [errors, calibration, latency_s, tolerance_s, off, seed] :
       {Late{{.gyro_latency_s = 0.03}, gyro_latency, 0.03, 0.004, 0.006, 2},
        {{.gyro_latency_s = 0.08}, gyro_latency, 0.08, 0.004, 0.006, 2},
        {{.gyro_latency_s = 0.11}, gyro_latency, 0.11, 0.004, 0.006, 2},
        {{.wheel_latency_s = 0.04}, wheel_latency, 0.04, 0.01, 0.008, 3},
        {{.wheel_latency_s = 0.08}, wheel_latency, 0.08, 0.01, 0.008, 3}}) {
    const Outcome outcome = drive(errors, seed);
    EXPECT_NEAR(outcome.calibration.value[calibration], latency_s, tolerance_s);
    EXPECT_LT(outcome.off, off) << latency_s;
    EXPECT_LT(outcome.nees, 6.0) << latency_s;
  }
}

TEST(LastingErrors, ALateSteeringDoesNoHarm) {
  const Outcome outcome = drive({.steering_latency_s = 0.05}, 4);
  EXPECT_LT(outcome.calibration.sigma[steering_latency], 0.02);
  EXPECT_LT(outcome.off, 0.006);
  EXPECT_LT(outcome.nees, 6.0);
}

TEST(LastingErrors, ACameraWhoseErrorsLastIsNotAveragedAway) {
  const double white = drive({}, 5).sigma_x;
  for (const double sigma : {0.02, 0.05}) {
    for (const double time_s : {1.0, 3.0, 8.0}) {
      const Outcome outcome = drive({.camera_lasting = sigma, .camera_lasting_s = time_s}, 5);
      EXPECT_GT(outcome.sigma_x, 3.0 * white) << sigma << ' ' << time_s;
      EXPECT_GT(outcome.nees, 0.2) << sigma << ' ' << time_s;
      EXPECT_LT(outcome.nees, 12.0) << sigma << ' ' << time_s;
    }
  }
}

/// Either the map or the filter may be wrong: the covariance contains both cases.
TEST(LastingErrors, ACameraWhoseMapJumpsIsNotFollowedInSilence) {
  for (const double jump : {0.2, 0.5, 3.0})
    EXPECT_LT(drive({.jump = jump}, 6).silent_s, 0.5) << jump;
  for (const double turn : {0.1, 0.4}) EXPECT_LT(drive({.turn = turn}, 7).silent_s, 0.5) << turn;
}

TEST(LastingErrors, AnOffsetWithinSigmasThatAreFarTooLargeIsNotFollowedInSilence) {
  for (const double jump : {0.4, 0.6, 1.0})
    EXPECT_LT(drive({.jump = jump, .camera_sigma = 0.16}, 8).silent_s, 0.5) << jump;
}

}  // namespace
}  // namespace odomd::estimator::testing::lasting_errors_test
