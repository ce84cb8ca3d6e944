// Sensors that contradict each other are found and named.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <numbers>
#include <random>

#include "tools/identify/common/agreement.hpp"

namespace odomd::tools::agreement_test {
namespace {

using estimator::Source;
using testing::AllOf;
using testing::HasSubstr;
using testing::StartsWith;

constexpr std::int64_t start_ns = 1'760'000'000'000'000'000;

struct Recorded {
  daemon::Config config;
  SignalLog log;
  std::vector<estimator::CameraPose> poses;

  Series& of(Source source) { return log.signals[static_cast<std::size_t>(source)]; }
  void scale(Source source, double factor) {
    for (double& value : of(source).value) value *= factor;
  }
  [[nodiscard]] std::string verdict(AgreementOptions options = {}) const {
    try {
      check_agreement(config, log, poses, options);
    } catch (const std::invalid_argument& error) {
      return error.what();
    }
    return "they agree";
  }
};

// A car that curves and weaves, with a steering 0.1 s ahead and a gyro 20 ms late; 40 s.
Recorded recorded(double phase = 0.0, double frequency = 0.7) {
  Recorded drive;
  drive.config.file = "car.toml";
  drive.log.first_ns = start_ns;
  drive.log.last_ns = start_ns + 40'000'000'000;
  std::mt19937 random(5);
  std::normal_distribution<double> noise;
  const auto steering = [&](double t) {
    return 0.2 * std::sin(frequency * t + phase) +
           0.1 * std::sin(4.3 * frequency * t + 2.0 * phase);
  };
  const auto speed = [](double t) { return 1.2 + 0.4 * std::sin(0.9 * t); };
  const auto yaw_rate = [&](double t) {
    return speed(t) * std::tan(steering(t)) / drive.config.vehicle.wheelbase();
  };
  double x = 0.0, y = 0.0, yaw = 3.0;
  for (int k = 0; k < 40'000; ++k) {
    const double t = 1e-3 * k;
    const std::int64_t t_ns = start_ns + std::int64_t{1'000'000} * k;
    const auto put = [&](Source source, double value) {
      drive.of(source).t_ns.push_back(t_ns);
      drive.of(source).value.push_back(value);
    };
    if (k % 10 == 0) {
      put(Source::yaw_rate, 1.05 * yaw_rate(t - 0.02) + 0.03 + 0.02 * noise(random));
      put(Source::wheel_rear, 0.95 * speed(t) + 0.02 * noise(random));
      put(Source::steering, steering(t + 0.1) + 0.02);
    }
    if (k % 35 == 0) {
      estimator::CameraPose pose;
      pose.capture_ns = pose.arrival_ns = t_ns;
      pose.x = x + 0.005 * noise(random);
      pose.y = y + 0.005 * noise(random);
      pose.yaw = std::remainder(yaw + 0.01 * noise(random), 2.0 * std::numbers::pi);
      pose.sigma_x = pose.sigma_y = 0.005;
      pose.sigma_yaw = 0.01;
      drive.poses.push_back(pose);
    }
    x += 1e-3 * speed(t) * std::cos(yaw);
    y += 1e-3 * speed(t) * std::sin(yaw);
    yaw += 1e-3 * yaw_rate(t);
  }
  return drive;
}

TEST(Agreement, SensorsThatAreSomewhatOffPass) {
  EXPECT_EQ(recorded().verdict(), "they agree");
  EXPECT_EQ(recorded(0.0, 1.5).verdict(), "they agree");
  Recorded blind = recorded();
  blind.poses.clear();
  EXPECT_EQ(blind.verdict(), "they agree");
}

TEST(Agreement, AFewPosesUpsideDownDoNotMatter) {
  Recorded drive = recorded();
  for (std::size_t i = 0; i < drive.poses.size(); i += 60) drive.poses[i].yaw += std::numbers::pi;
  EXPECT_EQ(drive.verdict(), "they agree");
}

TEST(Agreement, PosesInOtherUnitsAreNoFaultOfTheWheelsOrTheDrive) {
  Recorded drive = recorded();
  for (estimator::CameraPose& pose : drive.poses) {
    pose.x *= 1000.0;
    pose.y *= 1000.0;
  }
  for (const UnrelatedPoses unrelated : {UnrelatedPoses::refuse, UnrelatedPoses::accept})
    EXPECT_EQ(drive.verdict({.drive = "lap", .pose_source = "reference", .unrelated = unrelated}),
              "lap: the reference's poses: x and y go about 1000 times as far as the wheels: are "
              "the positions in millimetres? they must be metres");
  drive = recorded();
  for (estimator::CameraPose& pose : drive.poses) pose.yaw *= 180.0 / std::numbers::pi;
  EXPECT_EQ(drive.verdict({.unrelated = UnrelatedPoses::accept}),
            "the camera's poses: yaw turns about 57 times as far as the gyro: is it in degrees? it "
            "must be radians");
}

TEST(Agreement, AGyroOfTheWrongSignIsNamed) {
  Recorded drive = recorded();
  drive.scale(Source::yaw_rate, -1.0);
  EXPECT_THAT(drive.verdict({.drive = "lap"}),
              AllOf(StartsWith("lap: yaw_rate turns the other way than the camera"),
                    HasSubstr("can.signals.yaw_rate.scale")));
  drive.poses.clear();
  EXPECT_THAT(drive.verdict(), AllOf(StartsWith("yaw_rate turns the other way than wheels"),
                                     HasSubstr("can.signals.steering.scale")));
}

TEST(Agreement, ASteeringOfTheWrongSignIsNamed) {
  Recorded drive = recorded();
  drive.scale(Source::steering, -1.0);
  EXPECT_THAT(drive.verdict(), AllOf(StartsWith("steering turns the other way than the camera"),
                                     HasSubstr("can.signals.steering.scale")));
}

TEST(Agreement, ACameraAgainstBothIsNamedItself) {
  Recorded drive = recorded();
  for (estimator::CameraPose& pose : drive.poses) {
    pose.y = -pose.y;
    pose.yaw = -pose.yaw;
  }
  EXPECT_THAT(drive.verdict(), StartsWith("the camera turns the other way than yaw_rate and"));
}

TEST(Agreement, AGyroInDegreesIsNamed) {
  Recorded drive = recorded();
  drive.scale(Source::yaw_rate, 57.3);
  EXPECT_THAT(drive.verdict({.pose_source = "reference"}),
              AllOf(HasSubstr("times as far as the reference"), HasSubstr("can.signals.yaw_rate")));
}

TEST(Agreement, WithoutPosesAGyroFarOffWheelsAndSteeringIsNamed) {
  Recorded drive = recorded();
  drive.poses.clear();
  drive.scale(Source::yaw_rate, 57.3);
  EXPECT_THAT(drive.verdict(), AllOf(StartsWith("yaw_rate turns 6"),  // the gyro over-reads, too
                                     HasSubstr("times as far as by wheels and steering")));
  drive.scale(Source::yaw_rate, 1.0 / 57.3 / 57.3);
  EXPECT_THAT(drive.verdict(), HasSubstr("times as little as by wheels and steering"));
  drive.scale(Source::yaw_rate, 2.0 * 57.3);  // tyres that slip may do so
  EXPECT_EQ(drive.verdict(), "they agree");
}

TEST(Agreement, AWheelFarOffIsNamed) {
  for (const double factor : {0.6, 1.7, 3.6}) {
    Recorded drive = recorded();
    drive.scale(Source::wheel_rear, factor);
    EXPECT_THAT(drive.verdict(), AllOf(StartsWith("wheel_rear is "), HasSubstr("radius")));
  }
  Recorded drive = recorded();
  drive.scale(Source::wheel_rear, -1.0);
  EXPECT_THAT(drive.verdict(), StartsWith("wheel_rear runs backwards"));
}

TEST(Agreement, PosesOfAnotherDriveAreDistinguishedFromThoseOfThis) {
  Recorded drive = recorded();
  drive.poses = recorded(2.0, 0.53).poses;
  EXPECT_THAT(drive.verdict(), AllOf(HasSubstr("nothing in common"), HasSubstr("of this drive")));
  EXPECT_EQ(drive.verdict({.unrelated = UnrelatedPoses::accept}), "they agree");
}

TEST(Agreement, TheMessageOnPosesOfAnotherClockSaysHowLateTheyAre) {
  Recorded drive = recorded();
  const auto shifted = [&drive](double by_s) {
    Recorded other = drive;
    for (estimator::CameraPose& pose : other.poses) pose.capture_ns += std::llround(1e9 * by_s);
    return other;
  };
  EXPECT_EQ(shifted(0.1).verdict(), "they agree");
  EXPECT_THAT(shifted(0.5).verdict(),
              HasSubstr("the camera's poses are 0.4 s or more late compared"));
  EXPECT_THAT(shifted(-0.3).verdict(), HasSubstr("0.3 s early"));
  EXPECT_EQ(shifted(0.3).verdict({.unrelated = UnrelatedPoses::accept}), "they agree");
}

TEST(Agreement, PosesOfAnotherTimeAreReportedAtOnce) {
  Recorded drive = recorded();
  for (estimator::CameraPose& pose : drive.poses) pose.capture_ns += 3'600'000'000'000;
  EXPECT_THAT(drive.verdict(), HasSubstr("no camera pose is taken while the log lasts"));
}

// Circles at one speed: nothing varies, and only the sense of turning can be checked.
TEST(Agreement, SteadyCirclesShowTheSenseOnly) {
  Recorded drive = recorded();
  for (double& value : drive.of(Source::yaw_rate).value) value = 1.0;
  for (estimator::CameraPose& pose : drive.poses)
    pose.yaw = std::remainder(1e-9 * static_cast<double>(pose.capture_ns - start_ns),
                              2.0 * std::numbers::pi);
  drive.of(Source::wheel_rear) = {};
  EXPECT_EQ(drive.verdict(), "they agree");
  drive.scale(Source::yaw_rate, -1.0);
  EXPECT_THAT(drive.verdict(), StartsWith("yaw_rate turns the other way"));
}

TEST(Agreement, ADriveThatNeverTurnsShowsNothing) {
  Recorded drive = recorded();
  for (double& value : drive.of(Source::yaw_rate).value) value = 0.01;
  for (estimator::CameraPose& pose : drive.poses) pose.yaw = 0.0;
  for (double& value : drive.of(Source::steering).value) value = -0.001;
  drive.of(Source::wheel_rear) = {};
  EXPECT_EQ(drive.verdict(), "they agree");
}

}  // namespace
}  // namespace odomd::tools::agreement_test
