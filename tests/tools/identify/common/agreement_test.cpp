// Sensors that contradict each other are named.
#include <numbers>
#include <random>

#include "tests/diagnostics.hpp"
#include "tools/identify/common/agreement.hpp"

namespace odomd::tools::agreement_test {
namespace {

using diagnostics::Named;
using estimator::Source;
using testing::Optional;
using testing::ThrowsMessage;

constexpr std::int64_t start_ns = 1'760'000'000'000'000'000;

struct Recorded {
  daemon::Config config;
  SignalLog log;
  std::vector<estimator::CameraPose> poses;

  Series& of(Source source) { return log.of(source); }
  void scale(Source source, double factor) {
    for (double& value : of(source).value) value *= factor;
  }
  [[nodiscard]] std::optional<diagnostics::Diagnostic> verdict(
      const AgreementOptions& options = {}) const {
    return find_disagreement(config, log, poses, options);
  }
};

// 40 s of curves and weaving, with a steering signal 0.1 s early and a gyro 20 ms late.
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
    const auto put = [&](Source source, double value) { drive.of(source).add(t_ns, value); };
    if (k % 10 == 0) {
      put(Source::yaw_rate, 1.05 * yaw_rate(t - 0.02) + 0.03 + 0.02 * noise(random));
      put(Source::wheel_rear, 0.95 * speed(t) + 0.02 * noise(random));
      put(Source::steering, steering(t + 0.1) + 0.02);
    }
    if (k % 35 == 0) {
      const double noisy_x = x + 0.005 * noise(random), noisy_y = y + 0.005 * noise(random);
      const double noisy_yaw = std::remainder(yaw + 0.01 * noise(random), 2.0 * std::numbers::pi);
      drive.poses.push_back({t_ns, t_ns, noisy_x, noisy_y, noisy_yaw, 0.005, 0.005, 0.01});
    }
    x += 1e-3 * speed(t) * std::cos(yaw);
    y += 1e-3 * speed(t) * std::sin(yaw);
    yaw += 1e-3 * yaw_rate(t);
  }
  return drive;
}

TEST(Agreement, AcceptsSmallErrors) {
  EXPECT_FALSE(recorded().verdict());
  EXPECT_FALSE(recorded(0.0, 1.5).verdict());
  Recorded blind = recorded();
  blind.poses.clear();
  EXPECT_FALSE(blind.verdict());
  // A few poses with a reversed heading give no verdict either.
  Recorded drive = recorded();
  for (std::size_t i = 0; i < drive.poses.size(); i += 60) drive.poses[i].yaw += std::numbers::pi;
  EXPECT_FALSE(drive.verdict());
}

void turn_over(Recorded& drive) {
  for (estimator::CameraPose& pose : drive.poses) {
    pose.y = -pose.y;
    pose.yaw = -pose.yaw;
  }
}
void in_millimetres(Recorded& drive) {
  for (estimator::CameraPose& pose : drive.poses) {
    pose.x *= 1000.0;
    pose.y *= 1000.0;
  }
}
void in_degrees(Recorded& drive) {
  for (estimator::CameraPose& pose : drive.poses) pose.yaw *= 180.0 / std::numbers::pi;
}
template <Source source, int per_mille>
void scaled(Recorded& drive) {
  drive.scale(source, 1e-3 * per_mille);
}
void an_hour_late(Recorded& drive) {
  for (estimator::CameraPose& pose : drive.poses) pose.capture_ns += 3'600'000'000'000;
}
void of_another_drive(Recorded& drive) {
  drive.poses = recorded(2.0, 0.53).poses;
}

TEST(Agreement, NamesTheFault) {
  struct Fault {
    void (*make)(Recorded&);
    const char *kind, *says;
    AgreementOptions options = {};
  };
  constexpr auto accept = UnrelatedPoses::accept;
  const Fault faults[]{
      {in_millimetres,
       "positions_in_millimetres",
       "the reference's poses: ",
       {.pose_source = "reference"}},
      {in_millimetres, "positions_in_millimetres", "the camera's poses: ", {.unrelated = accept}},
      {in_degrees, "yaw_in_degrees", "the camera's poses: ", {.unrelated = accept}},
      {scaled<Source::yaw_rate, -1000>, "wrong_sign", "can.signals.yaw_rate.scale"},
      {scaled<Source::steering, -1000>, "wrong_sign", "can.signals.steering.scale"},
      {turn_over, "camera_mirrored", ""},
      {scaled<Source::yaw_rate, 57'300>,
       "scale_off",
       "can.signals.yaw_rate",
       {.pose_source = "reference"}},
      {scaled<Source::wheel_rear, 600>, "scale_off", "can.signals.wheel_rear"},
      {scaled<Source::wheel_rear, 1700>, "scale_off", "can.signals.wheel_rear"},
      {scaled<Source::wheel_rear, 3600>, "scale_off", "can.signals.wheel_rear"},
      {scaled<Source::wheel_rear, -1000>, "runs_backwards", "wheel_rear"},
      {an_hour_late, "camera_outside_log", ""},
      {of_another_drive, "camera_turns_unrelated", ""}};
  for (const Fault& fault : faults) {
    Recorded drive = recorded();
    fault.make(drive);
    EXPECT_THAT(drive.verdict(fault.options), Optional(Named(fault.kind, fault.says)));
  }
  Recorded drive = recorded();
  of_another_drive(drive);
  EXPECT_FALSE(drive.verdict({.unrelated = accept}));
}

TEST(Agreement, BeginsARefusalWithTheDrive) {
  Recorded drive = recorded();
  drive.scale(Source::yaw_rate, -1.0);
  EXPECT_THAT([&] { check_agreement(drive.config, drive.log, drive.poses, {.drive = "lap"}); },
              ThrowsMessage<std::invalid_argument>(StartsWith("lap: yaw_rate: ")));
  drive.poses.clear();
  EXPECT_THAT(drive.verdict(), Optional(Named("wrong_sign", "can.signals.steering.scale")));
}

TEST(Agreement, NamesAGyroFarFromWheelsAndSteeringWithoutPoses) {
  Recorded drive = recorded();
  drive.poses.clear();
  drive.scale(Source::yaw_rate, 57.3);
  // The gyro also reads 5 % too much, so the factor is 60.
  EXPECT_THAT(drive.verdict(), Optional(Named("scale_off", "yaw_rate: turns 6")));
  drive.scale(Source::yaw_rate, 1.0 / 57.3 / 57.3);
  EXPECT_THAT(drive.verdict(), Optional(Named("scale_off", "times as little")));
  drive.scale(Source::yaw_rate, 2.0 * 57.3);  // slipping tyres may explain this
  EXPECT_FALSE(drive.verdict());
}

TEST(Agreement, StatesTheDelayOfPosesOfAnotherClock) {
  Recorded drive = recorded();
  const auto shifted = [&drive](double by_s) {
    Recorded other = drive;
    for (estimator::CameraPose& pose : other.poses) pose.capture_ns += std::llround(1e9 * by_s);
    return other;
  };
  EXPECT_FALSE(shifted(0.1).verdict());
  EXPECT_THAT(shifted(0.5).verdict(), Optional(Named("clocks_differ", "0.4 s or more late")));
  EXPECT_THAT(shifted(-0.3).verdict(), Optional(Named("clocks_differ", "0.3 s early")));
  EXPECT_FALSE(shifted(0.3).verdict({.unrelated = UnrelatedPoses::accept}));
}

// Circles at one speed: without variation only the sign of the yaw rate can be checked.
TEST(Agreement, ChecksOnlyTheSignOnSteadyCircles) {
  Recorded drive = recorded();
  for (double& value : drive.of(Source::yaw_rate).value) value = 1.0;
  for (estimator::CameraPose& pose : drive.poses)
    pose.yaw = std::remainder(1e-9 * static_cast<double>(pose.capture_ns - start_ns),
                              2.0 * std::numbers::pi);
  drive.of(Source::wheel_rear) = {};
  EXPECT_FALSE(drive.verdict());
  drive.scale(Source::yaw_rate, -1.0);
  EXPECT_THAT(drive.verdict(), Optional(Named("wrong_sign", "yaw_rate")));
}

TEST(Agreement, AcceptsADriveThatNeverTurns) {
  Recorded drive = recorded();
  for (double& value : drive.of(Source::yaw_rate).value) value = 0.01;
  for (estimator::CameraPose& pose : drive.poses) pose.yaw = 0.0;
  for (double& value : drive.of(Source::steering).value) value = -0.001;
  drive.of(Source::wheel_rear) = {};
  EXPECT_FALSE(drive.verdict());
}

}  // namespace
}  // namespace odomd::tools::agreement_test
