// Time offsets between signals, for signals with known offsets.
#include <map>
#include <nlohmann/json.hpp>
#include <numbers>
#include <random>

#include "tests/gtest.hpp"
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
  estimator::CameraPose pose;
  pose.capture_ns = start_ns + std::llround(1e9 * t);
  pose.x = x;
  pose.y = y;
  pose.yaw = turned;
  return pose;
}

/// The rear wheels' speeds, `side` [m] left and right of the middle (below 0: exchanged), each with
/// noise of its own. Their spin adds a latency of `lag` [s per m/s].
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

const SourceOffset& of(const LatencyEstimate& estimate, Source source) {
  for (const SourceOffset& offset : estimate.offsets)
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
  Resampled one = grid;
  for (double& value : one.value) value = 1.0;
  regression.basis = {{grid}, {one}};
  const Offset found = solve(regression);
  EXPECT_EQ(found.failure, "");
  EXPECT_NEAR(found.value, 0.0123, 1e-4);
  EXPECT_NEAR(found.coefficients[0], 0.16, 1e-3);
  EXPECT_GT(found.explained, 0.99);
}

TEST(OffsetRegression, SaysThatNoiseHasNoOffset) {
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

TEST(Latency, OfWheelsShowsInTheDifferenceOfLeftAndRight) {
  SignalLog log = log_with_gyro();
  add_rear_wheels(log, 0.08, {.late = 0.021, .noise = 0.005}, 1e-3);
  std::vector<std::string> reports;
  const LatencyEstimate estimate = estimate_latencies(
      car(), log, {}, [&reports](const std::string& now) { reports.push_back(now); });
  EXPECT_THAT(reports, testing::Contains("wheel_rear_left and wheel_rear_right against yaw_rate"));
  for (const Source wheels : {Source::wheel_rear_left, Source::wheel_rear_right}) {
    const SourceOffset found = of(estimate, wheels);
    EXPECT_EQ(found.failure, "");
    EXPECT_NEAR(found.offset, 0.021, 2.0 * found.sigma);
    EXPECT_LT(found.sigma, 1.2e-3);
  }
}

// Interpolation between two samples reduces the noise, which must not shift the offset.
TEST(Latency, OfWheelsIsNotDrawnToWhereTheGyroIsLessNoisy) {
  SignalLog log = log_with_gyro();
  log.of(Source::yaw_rate) = sampled(yaw_rate, {.period = 0.005, .noise = 0.2});
  add_rear_wheels(log, 0.08, {.late = 0.02}, 1e-3);  // four samples of the gyro
  const SourceOffset found = of(estimate_latencies(car(), log, {}), Source::wheel_rear_left);
  EXPECT_NEAR(found.offset, 0.02, 1e-3);
}

// The derivative of a calm drive's yaw rate is mostly noise, which determines no offset.
TEST(Latency, OfWheelsIsNoMoreCertainThanTheGyrosNoiseAllows) {
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
    const SourceOffset found = of(estimate_latencies(car(), log, {}), Source::wheel_rear_left);
    if (!found.failure.empty()) continue;
    EXPECT_NEAR(found.offset, 0.02, 2.5 * found.sigma) << "seed " << seed;
  }
}

TEST(Latency, OfTheGyroShowsAgainstACamera) {
  const SignalLog log = log_with_gyro();
  std::vector<estimator::CameraPose> camera;
  for (double t = 0.0; t < 30.0; t += 0.035)
    camera.push_back(
        pose_at(t - 0.012, 0.0, 0.0, std::remainder(yaw(t) + 3.0, 2.0 * std::numbers::pi)));
  const SourceOffset found = of(estimate_latencies(car(), log, camera), Source::camera);
  EXPECT_EQ(found.failure, "");
  EXPECT_NEAR(found.offset, -0.012, 1e-3);
}

TEST(Latency, RefusesACameraThatSawAnotherDrive) {
  const estimator::CameraPose late = pose_at(60.0, 0.0, 0.0, 0.0);
  EXPECT_THROW((void)estimate_latencies(car(), log_with_gyro(), {{late}}), std::invalid_argument);
}

TEST(Latency, OfOneSpeedIsDeterminedByTheCamerasPathAlone) {
  SignalLog log = log_with_gyro();
  log.of(Source::wheel_rear) = sampled(speed, {.late = 0.03, .noise = 0.005});
  EXPECT_THAT(of(estimate_latencies(car(), log, {}), Source::wheel_rear).failure,
              testing::HasSubstr("--camera"));

  std::vector<estimator::CameraPose> camera;
  double x = 0.0, y = 0.0;
  constexpr double dt = 1e-3;
  int k = 0;
  for (double t = 0.0; t < 30.0; t += dt, ++k) {
    if (k % 35 == 0) camera.push_back(pose_at(t, x, y, yaw(t)));
    x += dt * speed(t) * std::cos(yaw(t));
    y += dt * speed(t) * std::sin(yaw(t));
  }
  const SourceOffset found = of(estimate_latencies(car(), log, camera), Source::wheel_rear);
  EXPECT_EQ(found.failure, "");
  EXPECT_NEAR(found.offset, 0.03, 3e-3);
}

TEST(Latency, OfExchangedWheelsIsNotReported) {
  SignalLog log = log_with_gyro();
  add_rear_wheels(log, -0.08, {.noise = 0.005});
  EXPECT_THAT(of(estimate_latencies(car(), log, {}), Source::wheel_rear_left).failure,
              testing::HasSubstr("left and right exchanged?"));
}

TEST(Latency, ADriveStraightAheadDeterminesNothing) {
  SignalLog log = log_with_gyro();
  log.of(Source::yaw_rate) = sampled([](double) { return 0.0; }, {.noise = 0.005});
  log.of(Source::wheel_rear_left) = sampled(speed, {.noise = 0.005});
  log.of(Source::wheel_rear_right) = sampled(speed, {.noise = 0.005, .seed = 8});
  EXPECT_NE(of(estimate_latencies(car(), log, {}), Source::wheel_rear_left).failure, "");
}

// At a steady speed the tyres' relaxation and the steering's lag look alike: details that no model
// contains must not separate them.
TEST(Latency, OfTheSteeringIsNoMoreCertainThanTheTyresAtASteadySpeed) {
  Lap lap("", "--camera camera.csv");
  const auto plant = nlohmann::json::parse(contents(lap.folder + "/plant.json"));
  const auto& value = lap.values.at("lag of the wheels behind steering, in all");
  const double half_a_cycle = 0.005;  // the command is updated in cycles and held
  EXPECT_NEAR(value["value"].get<double>(), plant["truth"]["steering_lag"].get<double>(),
              2.0 * value["sigma"].get<double>() + half_a_cycle);
}

// With poses stamped on arrival all sensors seem early: the camera is no clock, and 0 is wrong.
TEST(Latency, HoldsBackWhatIsEarlyAndBelievesTheGyroInTheCamerasPlace) {
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

TEST(Latency, NeedsAGyroAndTime) {
  SignalLog none;
  EXPECT_THROW((void)estimate_latencies(car(), none, {}), std::invalid_argument);
  EXPECT_THROW((void)estimate_latencies(car(), log_with_gyro(5.0), {}), std::invalid_argument);
}

}  // namespace
}  // namespace odomd::tools::latency_test
