// Time offsets, estimated for signals with known offsets, and values for [steering].
#include <map>
#include <numbers>
#include <random>

#include "daemon/core/config.hpp"
#include "tests/diagnostics.hpp"
#include "tests/tools/scratch.hpp"
#include "tools/identify/common/time_shift.hpp"
#include "tools/identify/latency/latency_estimate.hpp"

namespace odomd::tools::latency_test {
namespace {

using estimator::Source;

constexpr std::int64_t start_ns = 1'760'000'000'000'000'000;

// A yaw rate of several frequencies, its integral, and a varying speed.
double yaw_rate(double t) {
  return 1.2 * std::sin(2.1 * t) + 0.8 * std::sin(5.3 * t + 1.0) + 0.4 * std::sin(9.7 * t);
}
double yaw(double t) {
  return -1.2 / 2.1 * std::cos(2.1 * t) - 0.8 / 5.3 * std::cos(5.3 * t + 1.0) -
         0.4 / 9.7 * std::cos(9.7 * t);
}
double speed(double t) {
  return 1.5 + 0.5 * std::sin(1.3 * t) + 0.2 * std::sin(4.1 * t);
}

struct Sampling {
  double period = 0.01;
  double late = 0.0;  // latency of the stamps
  double noise = 0.0;
  double seconds = 30.0;
  unsigned seed = 7;
};

template <class F>
Series sampled(F value, const Sampling& how) {
  std::mt19937 random(how.seed);
  std::normal_distribution<double> noise(0.0, 1.0);
  Series series;
  for (double t = 0.003; t < how.seconds; t += how.period) {
    series.add(start_ns + std::llround(1e9 * (t + how.late)), value(t) + how.noise * noise(random));
  }
  return series;
}

estimator::CameraPose pose_at(double t, double x, double y, double turned) {
  return {.capture_ns = start_ns + std::llround(1e9 * t), .x = x, .y = y, .yaw = turned};
}

/// The rear wheels' speeds, `side` [m] left and right of the middle (below 0: exchanged), each with
/// independent noise. Their spin adds a latency of `lag` [s per m/s].
void add_rear_wheels(SignalLog& log, double side, const Sampling& how, double lag = 0.0) {
  const auto wheel = [&](double y, unsigned seed) {
    Sampling own = how;
    own.seed = seed;
    return sampled([=](double t) { return speed(t) + y * yaw_rate(t - lag * speed(t)); }, own);
  };
  log.of(Source::wheel_rear_left) = wheel(-side, 8);
  log.of(Source::wheel_rear_right) = wheel(side, 9);
}

daemon::Config car() {
  daemon::Config config;
  config.file = "car.toml";
  return config;
}

SignalLog log_with_gyro(double seconds = 30.0) {
  SignalLog log;
  log.first_ns = start_ns;
  log.last_ns = start_ns + std::llround(1e9 * seconds);
  log.of(Source::yaw_rate) =
      sampled(yaw_rate, {.period = 0.005, .noise = 0.005, .seconds = seconds});
  return log;
}

/// A lap at a steady speed, and what odom identify latency finds in it after `change`.
struct Lap {
  explicit Lap(const std::string& change, const std::string& options) {
    outcome =
        run_shell("cd " + folder + " && " + change +
                  " odom identify latency --json --config car.toml --can drive.log " + options);
    EXPECT_EQ(outcome.status, 0) << outcome.err;
    const auto found = nlohmann::json::parse(outcome.out);
    for (const auto& value : found["values"]) values[value["name"]] = value;
  }
  Scratch scratch;
  std::string folder = simulate(scratch, "--speed 1 --laps 2 --seed 1", "lap");
  Outcome outcome;
  std::map<std::string, nlohmann::json> values;  ///< by name
};

SourceOffset offset_of(Source source, const SignalLog& log,
                       const std::vector<estimator::CameraPose>& camera = {}) {
  for (const SourceOffset& offset : estimate_latencies(car(), log, camera).offsets)
    if (offset.source == source) return offset;
  throw std::logic_error("no such source");
}

TEST(OffsetRegression, FindsAShiftOfAFractionOfASample) {
  const Series reference = sampled(yaw_rate, {.period = 0.005});
  OffsetRegression regression;
  for (double t = 1.0; t < 29.0; t += 0.035) {
    regression.t.push_back(t);
    regression.y.push_back(0.16 * yaw_rate(t - 0.0123) + 0.05);
  }
  const Resampled grid = resampled(reference, start_ns, 0.0, 30.0);
  regression.basis = {{grid}, {on_grid_of(grid, [](double) { return 1.0; })}};
  const Offset found = solve(regression);
  EXPECT_EQ(found.failure, "");
  EXPECT_NEAR(found.value, 0.0123, 1e-4);
  EXPECT_NEAR(found.coefficients[0], 0.16, 1e-3);
  EXPECT_GT(found.explained, 0.99);
}

TEST(OffsetRegression, FindsNoOffsetInNoise) {
  OffsetRegression regression;
  std::mt19937 random(1);
  std::normal_distribution<double> noise;
  for (double t = 1.0; t < 29.0; t += 0.035) {
    regression.t.push_back(t);
    regression.y.push_back(noise(random));
  }
  regression.basis = {{resampled(sampled(yaw_rate, {}), start_ns, 0.0, 30.0)}};
  EXPECT_NE(solve(regression).failure, "");
}

TEST(Latency, OfWheelsComesFromTheDifferenceOfLeftAndRight) {
  SignalLog log = log_with_gyro();
  add_rear_wheels(log, 0.08, {.late = 0.021, .noise = 0.005}, 1e-3);
  std::vector<std::string> reports;
  (void)estimate_latencies(car(), log, {},
                           [&reports](const std::string& now) { reports.push_back(now); });
  EXPECT_THAT(reports, testing::Contains("wheel_rear_left and wheel_rear_right against yaw_rate"));
  for (const Source wheels : {Source::wheel_rear_left, Source::wheel_rear_right}) {
    const SourceOffset found = offset_of(wheels, log);
    EXPECT_EQ(found.failure, "");
    EXPECT_NEAR(found.offset, 0.021, 2.0 * found.sigma);
    EXPECT_LT(found.sigma, 1.2e-3);
  }
}

// Interpolation between two samples reduces the noise, which must not shift the offset.
TEST(Latency, OfWheelsIsUnbiasedByInterpolationBetweenGyroSamples) {
  SignalLog log = log_with_gyro();
  log.of(Source::yaw_rate) = sampled(yaw_rate, {.period = 0.005, .noise = 0.2});
  add_rear_wheels(log, 0.08, {.late = 0.02}, 1e-3);  // 0.02 s: four samples of the gyro
  const SourceOffset found = offset_of(Source::wheel_rear_left, log);
  EXPECT_NEAR(found.offset, 0.02, 1e-3);
}

// The derivative of a calm drive's yaw rate is mostly noise, which determines no offset.
TEST(Latency, OfWheelsHasAnHonestSigmaWithANoisyGyro) {
  const auto calm = [](double t) { return 0.2 * std::sin(0.5 * t) + 0.1 * std::sin(1.1 * t); };
  for (unsigned seed = 1; seed <= 6; ++seed) {
    SignalLog log = log_with_gyro(60.0);
    const auto noisy = [seed](double noise, unsigned which) {
      return Sampling{.late = 0.02, .noise = noise, .seconds = 60.0, .seed = 3 * seed + which};
    };
    Sampling gyro = noisy(0.02, 0);
    gyro.late = 0.0;
    log.of(Source::yaw_rate) = sampled(calm, gyro);
    log.of(Source::wheel_rear_left) =
        sampled([&](double t) { return speed(t) - 0.08 * calm(t); }, noisy(0.005, 1));
    log.of(Source::wheel_rear_right) =
        sampled([&](double t) { return speed(t) + 0.08 * calm(t); }, noisy(0.005, 2));
    const SourceOffset found = offset_of(Source::wheel_rear_left, log);
    if (!found.failure.empty()) continue;
    EXPECT_NEAR(found.offset, 0.02, 2.5 * found.sigma) << "seed " << seed;
  }
}

TEST(Latency, OfTheGyroComesFromTheCamera) {
  const SignalLog log = log_with_gyro();
  std::vector<estimator::CameraPose> camera;
  for (double t = 0.0; t < 30.0; t += 0.035)
    camera.push_back(
        pose_at(t - 0.012, 0.0, 0.0, std::remainder(yaw(t) + 3.0, 2.0 * std::numbers::pi)));
  const SourceOffset found = offset_of(Source::camera, log, camera);
  EXPECT_EQ(found.failure, "");
  EXPECT_NEAR(found.offset, -0.012, 1e-3);
}

TEST(Latency, OfOneSpeedNeedsTheCamerasPath) {
  SignalLog log = log_with_gyro();
  log.of(Source::wheel_rear) = sampled(speed, {.late = 0.03, .noise = 0.005});
  EXPECT_THAT(offset_of(Source::wheel_rear, log).failure, testing::HasSubstr("--camera"));

  std::vector<estimator::CameraPose> camera;
  double x = 0.0, y = 0.0;
  constexpr double dt = 1e-3;
  int k = 0;
  for (double t = 0.0; t < 30.0; t += dt, ++k) {
    if (k % 35 == 0) camera.push_back(pose_at(t, x, y, yaw(t)));
    x += dt * speed(t) * std::cos(yaw(t));
    y += dt * speed(t) * std::sin(yaw(t));
  }
  const SourceOffset found = offset_of(Source::wheel_rear, log, camera);
  EXPECT_EQ(found.failure, "");
  EXPECT_NEAR(found.offset, 0.03, 3e-3);
}

TEST(Latency, OfExchangedWheelsIsNotReported) {
  SignalLog log = log_with_gyro();
  add_rear_wheels(log, -0.08, {.noise = 0.005});
  EXPECT_THAT(offset_of(Source::wheel_rear_left, log).failure,
              testing::HasSubstr("left and right exchanged?"));
}

TEST(Latency, IsUndeterminedOnAStraightDrive) {
  SignalLog log = log_with_gyro();
  log.of(Source::yaw_rate) = sampled([](double) { return 0.0; }, {.noise = 0.005});
  log.of(Source::wheel_rear_left) = sampled(speed, {.noise = 0.005});
  log.of(Source::wheel_rear_right) = sampled(speed, {.noise = 0.005, .seed = 8});
  EXPECT_NE(offset_of(Source::wheel_rear_left, log).failure, "");
}

// At a steady speed the tyres' relaxation and the steering's lag look alike: effects outside the
// model must not make them seem distinct.
TEST(Latency, OfTheSteeringHasAnHonestSigmaAtASteadySpeed) {
  Lap lap("", "--camera camera.csv");
  const auto plant = nlohmann::json::parse(contents(lap.folder + "/plant.json"));
  const auto& value = lap.values.at("lag of the wheels behind steering, in all");
  const double half_a_cycle = 0.005;  // the command is updated in cycles and held
  EXPECT_NEAR(value["value"].get<double>(), plant["truth"]["steering_lag"].get<double>(),
              2.0 * value["sigma"].get<double>() + half_a_cycle);
}

// With poses stamped on arrival all sensors seem early, but no latency can be negative.
TEST(Latency, RejectsEarlySensorsAndFallsBackToTheGyro) {
  Lap lap("awk -F, -v OFS=, 'NR > 1 {$2 = $1} 1' camera.csv > late.csv &&",
          "--camera late.csv --write car.toml");
  EXPECT_THAT(lap.outcome.err, AllOf(HasSubstr("the gyro's configured latency, 0.0 ms, is assumed"),
                                     Not(HasSubstr("can.signals.yaw_rate.latency"))));
  const auto& gyro = lap.values.at("latency of yaw_rate");
  EXPECT_FALSE(gyro["determined"].get<bool>());
  EXPECT_THAT(gyro["remark"].get<std::string>(), HasSubstr("which is not possible"));
  EXPECT_THAT(lap.values.at("latency of accel_x")["remark"].get<std::string>(),
              HasSubstr("only known in the gyro's"));
  const auto& wheel = lap.values.at("latency of wheel_rear_left");
  EXPECT_TRUE(wheel["determined"].get<bool>());
  EXPECT_NEAR(wheel["value"].get<double>(), 0.005, 2.0 * wheel["sigma"].get<double>());
}

TEST(Latency, RefusesAMissingGyroAShortLogAndAnotherDrivesCamera) {
  SignalLog none;
  EXPECT_THROW((void)estimate_latencies(car(), none, {}), std::invalid_argument);
  EXPECT_THROW((void)estimate_latencies(car(), log_with_gyro(5.0), {}), std::invalid_argument);
  const estimator::CameraPose late = pose_at(60.0, 0.0, 0.0, 0.0);
  EXPECT_THROW((void)estimate_latencies(car(), log_with_gyro(), {{late}}), std::invalid_argument);
}

SteeringResponse response(double delay, double lag, double sigma_whole) {
  SteeringResponse s;
  s.dead_time = {delay, 0.012};
  s.time_constant = {lag, 0.012};
  s.in_all = {delay + lag, sigma_whole};
  return s;
}

Findings actuator(const SteeringResponse& response, const Measured& clock = {},
                  const estimator::SteeringActuator& configured = {}) {
  Findings findings;
  add_actuator(response, clock, configured, findings);
  return findings;
}

TEST(ActuatorFindings, AreDeterminedIfDelayAndLagAreSeparable) {
  const auto found = actuator(response(0.064, 0.1, 0.004), {0.004, 0.0});
  ASSERT_EQ(found.values.size(), 2U);
  EXPECT_EQ(found.values[0].key, "steering.delay");
  EXPECT_EQ(found.values[0].determined, Determined::yes);
  EXPECT_NEAR(found.values[0].value, 0.06, 1e-12);  // without the gyro's latency of 4 ms
  EXPECT_EQ(found.values[1].key, "steering.lag");
  EXPECT_EQ(found.values[1].value, 0.1);
  EXPECT_THAT(found.warnings, testing::IsEmpty());
}

TEST(ActuatorFindings, AreUndeterminedForAMeasuredAngle) {
  const auto found = actuator(response(-0.02, 0.025, 0.004));
  for (const Finding& finding : found.values) {
    EXPECT_EQ(finding.determined, Determined::no);
    EXPECT_EQ(finding.key, "");
    EXPECT_THAT(finding.remark, testing::HasSubstr("none visible, 5 +- 4 ms in total"));
  }
  EXPECT_THAT(actuator(response(-0.02, 0.025, 0.004), {}, {.lag_s = 0.1}).warnings,
              testing::ElementsAre(diagnostics::Named("actuator_not_seen", "100 ms")));
}

TEST(ActuatorFindings, AreUndeterminedWithoutExcitation) {
  const auto remark = [](const SteeringResponse& s) {
    const auto found = actuator(s);
    EXPECT_EQ(found.values[0].determined, Determined::no);
    return found.values[0].remark;
  };
  EXPECT_THAT(remark(response(0.0, 0.03, 0.002)), testing::HasSubstr("together 30 +- 2 ms"));
  EXPECT_THAT(remark(response(0.02, 0.05, 0.02)),
              testing::HasSubstr("70 +- 20 ms in total; drive"));
  EXPECT_THAT(remark(response(0.45, 0.05, 0.04)), testing::HasSubstr("500 +- 40 ms in total"));
  EXPECT_THAT(remark(response(0.6, 0.1, 0.01)), testing::HasSubstr("more than [steering] allows"));
  SteeringResponse failed = response(0.06, 0.1, 0.004);
  failed.failure = "the car does not turn";
  EXPECT_EQ(remark(failed), "the car does not turn");
}

TEST(ActuatorFindings, AreNeverNegative) {
  const auto found = actuator(response(-0.004, 0.2, 0.004));
  EXPECT_EQ(found.values[0].determined, Determined::yes);
  EXPECT_EQ(found.values[0].value, 0.0);
  EXPECT_THAT(found.values[0].remark, testing::HasSubstr("measured -4.0 ms"));
}

// The simulated servo, and a drive with a measured steering angle.
TEST(ActuatorFindings, AreThoseOfTheSimulatedServo) {
  const Scratch scratch;
  const auto steering_after = [&scratch](const std::string& options) {
    const std::string drive = scratch.path("drive").string();
    must_run("odom sim --force --seed 4 " + options + " --out " + drive);
    must_run("cd " + drive +
             " && odom identify latency --config car.toml --can drive.log --camera camera.csv "
             "--write car.toml");
    return daemon::load_config(drive + "/car.toml").vehicle.steering;
  };
  const estimator::SteeringActuator servo = steering_after("--scenario stop-and-go --servo");
  EXPECT_NEAR(servo.delay_s, 0.06, 0.025);
  EXPECT_NEAR(servo.lag_s, 0.1, 0.025);
  EXPECT_NEAR(servo.delay_s + servo.lag_s, 0.16, 0.008);
  const estimator::SteeringActuator none =
      steering_after("--scenario stop-and-go --steering-commanded 0");
  EXPECT_EQ(none.delay_s, 0.0);
  EXPECT_EQ(none.lag_s, 0.0);
}

}  // namespace
}  // namespace odomd::tools::latency_test
