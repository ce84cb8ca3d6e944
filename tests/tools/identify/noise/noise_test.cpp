#include "tests/tools/scratch.hpp"
#include "tools/identify/noise/standing_noise.hpp"
#include "tools/math/random.hpp"

namespace odomd::tools::noise_test {
namespace {

struct Sensor {
  double sigma = 0.01;
  double bias = 0.3;
  double walk = 0.0;
};

// A sensor at 100 Hz.
Series record(const Sensor& sensor, std::size_t samples, std::uint64_t seed) {
  sim::RandomStream random(seed, "sensor");
  Series series;
  double bias = sensor.bias;
  for (std::size_t i = 0; i < samples; ++i) {
    series.add(static_cast<std::int64_t>(i) * 10'000'000, bias + sensor.sigma * random.normal());
    bias += sensor.walk * 0.1 * random.normal();
  }
  return series;
}

bool is_inside(const Measured& measured, double truth, double sigmas) {
  return std::fabs(measured.value - truth) <= sigmas * measured.sigma;
}

TEST(StandingNoise, SeparatesWhiteNoiseBiasAndItsWalk) {
  int inside[3] = {};
  constexpr int seeds = 20;
  for (int seed = 0; seed < seeds; ++seed) {
    const Sensor sensor{.walk = 1e-3};
    const StandingNoise noise =
        standing_noise(record(sensor, 30'000, static_cast<std::uint64_t>(seed)), "gyro");
    ASSERT_TRUE(noise.walk);
    inside[0] += is_inside(noise.sigma, sensor.sigma, 2.0);
    inside[1] += is_inside(noise.bias, sensor.bias, 2.0);
    inside[2] += is_inside(*noise.walk, sensor.walk, 2.0);
    EXPECT_NEAR(noise.density().value, 0.1 * noise.sigma.value, 1e-9);
    EXPECT_LT(noise.walk->sigma, 0.3 * sensor.walk);
    EXPECT_EQ(noise.outliers, 0);
  }
  for (const int count : inside) EXPECT_GE(count, 16);
}

TEST(StandingNoise, BoundsAWalkTooSmallToDetect) {
  const StandingNoise noise = standing_noise(record({.walk = 0.0}, 3'000, 1), "gyro");
  EXPECT_FALSE(noise.walk);
  EXPECT_GT(noise.walk_below, 0.0);
  EXPECT_LT(noise.walk_below, 3e-3);
  EXPECT_TRUE(is_inside(noise.sigma, 0.01, 3.0));
}

// A single outlier would otherwise weigh as much as ten thousand samples.
TEST(StandingNoise, LeavesOutOutliers) {
  Series series = record({}, 30'000, 1);
  for (std::size_t i = 0; i < 10; ++i) series.value[1'000 + 2'500 * i] += 4.0;
  for (std::size_t i = 20'000; i < 20'030; ++i) series.value[i] += 0.1;
  const StandingNoise noise = standing_noise(series, "gyro");
  EXPECT_TRUE(is_inside(noise.sigma, 0.01, 3.0)) << noise.sigma.value;
  EXPECT_GE(noise.outliers, 38);
  EXPECT_TRUE(noise.outliers_left_out);
  EXPECT_FALSE(noise.walk);
}

// A filtering sensor, or a message sent more often than its value changes: the stated sigma is
// derived from long means, and no bias walk is found.
TEST(StandingNoise, OfCorrelatedSamplesIsThatOfTheirMeans) {
  const Series white = record({}, 30'000, 1);
  Series filtered = white, held = white;
  for (std::size_t i = 7; i < white.size(); ++i) {
    double sum = 0.0;
    for (std::size_t k = 0; k < 8; ++k) sum += white.value[i - k];
    filtered.value[i] = sum / 8.0;
  }
  for (std::size_t i = 0; i < white.size(); ++i) held.value[i] = white.value[i - i % 5];
  for (const auto& [series, sigma] :
       {std::pair{&filtered, 0.01}, std::pair{&held, 0.01 * std::sqrt(5.0)}}) {
    const StandingNoise noise = standing_noise(*series, "gyro");
    EXPECT_GT(noise.group_size, 4U);
    EXPECT_TRUE(is_inside(noise.sigma, sigma, 2.0)) << noise.sigma.value;
    EXPECT_LT(noise.sigma.sigma, 0.1 * sigma);
    EXPECT_TRUE(is_inside(noise.bias, 0.3, 2.5)) << noise.bias.value;
    EXPECT_FALSE(noise.walk);
  }
  EXPECT_EQ(standing_noise(white, "gyro").group_size, 1U);
}

TEST(StandingNoise, RefusesRecordsWithoutNoise) {
  Series series = record({.sigma = 0.0}, 1'000, 1);
  EXPECT_THAT(message_of([&] { (void)standing_noise(series, "a.log: yaw_rate"); }),
              HasSubstr("a.log: yaw_rate: always 0.3"));
  EXPECT_THAT(message_of([&] { (void)standing_noise(record({}, 100, 1), "a.log"); }),
              HasSubstr("100 samples are too few"));
  Series in_ms = record({}, 1'000, 1);
  for (std::int64_t& time : in_ms.t_ns) time *= 1000;
  EXPECT_THAT(message_of([&] { (void)standing_noise(in_ms, "a.csv"); }),
              HasSubstr("a.csv: a sample every 10 s: are the times in ms?"));
}

// The record rounded to steps of the sensor's resolution.
Series in_steps(Series series, double step) {
  for (double& value : series.value) value = step * std::round(value / step);
  return series;
}

TEST(StandingNoise, OfCoarseStepsIsAtLeastTheRoundingNoise) {
  constexpr double step = 0.01;
  // Noise of a tenth and of a fifth of a step; the bias's error depends on where in a step the bias
  // lies.
  for (const double sigma : {0.001, 0.002}) {
    for (const double bias : {0.0012, 0.0031, 0.0044}) {
      const Series fine = record({.sigma = sigma, .bias = bias}, 60'000, 1);
      const StandingNoise noise = standing_noise(in_steps(fine, step), "gyro");
      EXPECT_NEAR(noise.resolution, step, 1e-9);
      EXPECT_TRUE(is_inside(noise.bias, bias, 2.0)) << sigma << ' ' << bias;
      EXPECT_GE(noise.sigma.value, step / std::sqrt(12.0));
      EXPECT_FALSE(noise.walk);
      EXPECT_EQ(noise.outliers, 0);
    }
  }
}

TEST(StandingNoise, OfASingleStepIsTheRoundingNoise) {
  Series series = record({.sigma = 0.0}, 6'000, 1);
  series.value[3'000] += 0.001;
  const StandingNoise noise = standing_noise(series, "gyro");
  EXPECT_TRUE(noise.resolution_hides_noise);
  EXPECT_NEAR(noise.sigma.value, 0.001 / std::sqrt(12.0), 1e-9);
  EXPECT_NEAR(noise.density().value, 0.1 * noise.sigma.value, 1e-9);
}

TEST(StandingNoise, OfFineStepsIsThatOfTheSensor) {
  const StandingNoise noise = standing_noise(in_steps(record({}, 30'000, 1), 0.005), "gyro");
  EXPECT_FALSE(noise.resolution_hides_noise);
  EXPECT_NEAR(noise.sigma.value, std::hypot(0.01, 0.005 / std::sqrt(12.0)), 2e-4);
}

TEST(IdentifyNoise, WritesTheNoiseOfAStandingCar) {
  const Scratch scratch;
  const std::string car =
      simulate(scratch, "--standstill 30 --duration 30 --gyro-noise 0.012") + "/car.toml";
  scratch.must_run(
      "cd drive && odom identify noise --config car.toml --can drive.log --write car.toml");
  EXPECT_THAT(contents(car), HasSubstr("(sigma: odom identify noise: +- "));
  // R as in the paper, ten times the gyro's variance; v_x is unchanged.
  const auto R = daemon::load_config(car).paper_noise.R;
  EXPECT_NEAR(R[0], 10.0 * 0.012 * 0.012, 1e-4);
  EXPECT_EQ(R[1], 0.10);
  scratch.must_run("cd drive && odom replay --config car.toml --can drive.log --out /dev/null");
}

TEST(IdentifyNoise, RefusesUnusableRecords) {
  const Scratch scratch;
  simulate(scratch, "--duration 10 --standstill 2");
  scratch.must_run("grep ' 1A2#' drive/drive.log > imu.log");
  scratch.write("a.csv", "t,speed\n1,2\n");
  scratch.write("nothing.csv", "");
  // Without the wheels, the gyro shows that the car moves.
  expect_answers(scratch, 2, "odom identify noise", R"(
 -> give a record of the standing car
--config drive/car.toml --can drive/drive.log -> the car moves: wheel_
--config drive/car.toml --can imu.log -> the car moves: yaw_rate is
--config drive/car.toml --can drive/drive.log --to 0.5 -> samples are too few
--csv nothing.csv -> a first line "t,yaw_rate,accel_x,accel_y" is expected, with t [s]
--csv a.csv -> none of the columns yaw_rate, accel_x, accel_y
)");
}

}  // namespace
}  // namespace odomd::tools::noise_test
