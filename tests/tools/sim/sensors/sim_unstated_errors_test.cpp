// Sensor errors that no configuration states: latency, dead band, range, warm-up, and correlated
// camera errors.
#include <cstring>

#include "tests/gtest.hpp"
#include "tools/sim/car_bus.hpp"
#include "tools/sim/sensors/camera.hpp"
#include "tools/sim/sensors/sensors.hpp"

namespace odomd::sim::sim_unstated_errors_test {
namespace {

using enum Parameter;

constexpr double radius = 0.033;

ParameterSet ideal() {
  ParameterSet parameters = default_parameters(CarKind::scale_car);
  make_ideal(parameters);
  parameters[imu_x] = parameters[imu_y] = 0.0;
  return parameters;
}

// All measured quantities grow by 1 per second: yaw rate, accelerations, wheel speeds, steering
// angle.
PlantOutput ramp(double t) {
  PlantOutput car{.yaw_rate = t, .accel_x = t, .accel_y = t, .steering = t};
  for (double& angle : car.wheel_angle) angle = 0.5 * t * t / radius;
  for (double& rate : car.wheel_rate) rate = t / radius;
  return car;
}

double signal(const can::Frame& frame, unsigned start, unsigned bits, double factor) {
  std::uint64_t raw = 0;
  std::memcpy(&raw, frame.data.data(), sizeof raw);
  return factor * static_cast<double>(static_cast<std::int64_t>(raw << (64U - bits - start)) >>
                                      (64U - bits));
}

// The last values on the bus after half a second of the ramp: yaw rate, a_y, a wheel, steering.
std::array<double, 4> last_values(const ParameterSet& truth) {
  CarBus bus(truth, radius, 1);
  std::vector<can::Frame> frames;
  for (std::int64_t t = 0; t < 500'000'000; t += 500'000) {
    const double now = 1e-9 * static_cast<double>(t);
    bus.advance(t, ramp(now), t + 500'000, ramp(now + 0.0005), frames);
  }
  std::array<double, 4> values{};
  for (const can::Frame& frame : frames) {
    if (frame.id == 0x1A2) {
      values[0] = signal(frame, 12, 18, 0.0002);
      values[1] = signal(frame, 47, 17, 0.0025);
    }
    if (frame.id == 0x1A0) values[2] = signal(frame, 16, 24, 1e-5);
    if (frame.id == 0x1A3) values[3] = signal(frame, 16, 24, 1e-6);
  }
  return values;
}

TEST(Latency, MakesOneSourceLateAndLeavesTheOthersAlone) {
  const std::array<double, 4> in_time = last_values(ideal());
  for (const double value : in_time) EXPECT_NEAR(value, 0.49, 0.011);
  constexpr std::array latencies{gyro_latency, accel_latency, wheel_latency, steering_latency};
  for (std::size_t late = 0; late < latencies.size(); ++late) {
    ParameterSet truth = ideal();
    truth[latencies[late]] = 0.0803;
    const std::array<double, 4> values = last_values(truth);
    for (std::size_t i = 0; i < values.size(); ++i)
      EXPECT_NEAR(values[i], in_time[i] - (i == late ? 0.0803 : 0.0), i == late ? 0.003 : 0.0)
          << late << ' ' << i;
  }
}

TEST(PastOutputs, KeepsWheelsTurningBeforeTheFirst) {
  PastOutputs past(20'000'000);
  for (std::int64_t t = 0; t <= 100'000'000; t += 500'000)
    past.add(t, ramp(1.0 + 1e-9 * static_cast<double>(t)));
  EXPECT_NEAR(past.at(80'250'000).yaw_rate, 1.08025, 1e-12);

  PastOutputs begun(20'000'000);
  begun.add(0, ramp(1.0));
  const PlantOutput before = begun.at(-10'000'000);
  EXPECT_EQ(before.yaw_rate, 1.0);
  EXPECT_NEAR(before.wheel_angle[0], (0.5 - 0.01) / radius, 1e-12);
}

TEST(WheelEncoder, ReadsZeroBelowTheDeadBand) {
  ParameterSet truth = ideal();
  truth[wheel_dead_band] = 0.5;
  WheelEncoder encoder(truth, rear_left, radius, 1);
  PlantOutput car;
  const auto read = [&](double speed) {
    car.wheel_angle[rear_left] += speed * 0.01 / radius;
    return encoder.read(car, 0.01);
  };
  EXPECT_EQ(read(0.49), 0.0);
  EXPECT_NEAR(read(0.51), 0.51, 1e-9);
  EXPECT_EQ(read(-0.49), 0.0);
  EXPECT_NEAR(read(-0.51), -0.51, 1e-9);
}

TEST(WheelEncoder, ReadsTheSpeedAtOnceOfAWheelThatTurns) {
  WheelEncoder encoder(ideal(), rear_left, radius, 1);
  EXPECT_NEAR(encoder.read({.wheel_rate = {0.0, 0.0, 30.0, 0.0}}, 0.01), 30.0 * radius, 1e-9);
}

TEST(Sensors, SaturateAtTheirRange) {
  ParameterSet truth = ideal();
  truth[gyro_range] = 2.0;
  truth[accel_range] = 5.0;
  truth[steering_range] = 0.3;
  Imu imu(truth, 1);
  for (const double sign : {1.0, -1.0}) {
    const PlantOutput hard{
        .yaw_rate = sign * 3.0, .accel_x = sign * 8.0, .accel_y = sign * 6.0, .steering = sign};
    const ImuReading reading = imu.read(hard, hard, 0.005);
    EXPECT_EQ(reading.yaw_rate, sign * 2.0);
    EXPECT_EQ(reading.accel_x, sign * 5.0);
    EXPECT_EQ(reading.accel_y, sign * 5.0);
    EXPECT_EQ(SteeringSensor(truth, 1).read(hard), sign * 0.3);
    EXPECT_NEAR(imu.read({.yaw_rate = sign}, {}, 0.005).yaw_rate, sign, 1e-12);
  }
}

TEST(Imu, DriftsAsItWarmsUp) {
  ParameterSet truth = ideal();
  truth[gyro_drift] = -0.02;
  truth[gyro_drift_time] = 60.0;
  Imu imu(truth, 1);
  double read = 0.0;
  const auto after = [&](double seconds) {
    for (long k = 0; k < std::lround(seconds / 0.005); ++k) read = imu.read({}, {}, 0.005).yaw_rate;
    return read;
  };
  EXPECT_NEAR(after(0.005), 0.0, 1e-5);
  EXPECT_NEAR(after(60.0), -0.02 * (1.0 - std::exp(-1.0)), 1e-5);
  EXPECT_NEAR(after(600.0), -0.02, 1e-5);
}

std::vector<estimator::CameraPose> pictures(const ParameterSet& truth, double seconds) {
  Camera camera(truth, {}, 5);
  std::vector<estimator::CameraPose> poses;
  for (std::int64_t t = 0; t < std::llround(seconds * 1e9); t += 5'000'000)
    camera.advance(t, {}, t + 5'000'000, {}, poses);
  return poses;
}

TEST(Camera, ErrsForAsLongAsIsAskedFor) {
  ParameterSet truth = ideal();
  truth[camera_lasting_noise] = 0.05;
  truth[camera_lasting_yaw_noise] = 0.02;
  truth[camera_lasting_time] = 2.0;
  const auto poses = pictures(truth, 20'000.0);
  const auto later = static_cast<std::size_t>(std::lround(2.0 / truth[camera_period]));
  double variance = 0.0, covariance = 0.0, yaw_variance = 0.0;
  for (std::size_t i = later; i < poses.size(); ++i) {
    variance += poses[i].y * poses[i].y;
    covariance += poses[i].y * poses[i - later].y;
    yaw_variance += poses[i].yaw * poses[i].yaw;
  }
  const auto count = static_cast<double>(poses.size() - later);
  EXPECT_NEAR(std::sqrt(variance / count), 0.05, 0.002);
  EXPECT_NEAR(std::sqrt(yaw_variance / count), 0.02, 0.001);
  EXPECT_NEAR(covariance / variance, std::exp(-1.0), 0.04);
  // The full error from the start, with its sigma.
  EXPECT_NE(poses.front().x, 0.0);
  EXPECT_EQ(poses.front().sigma_x, 0.05);
  EXPECT_EQ(poses.front().sigma_yaw, 0.02);
}

TEST(Camera, StampsPosesLaterThanTheirPictures) {
  ParameterSet truth = default_parameters(CarKind::scale_car);
  const auto in_time = pictures(truth, 5.0);
  truth[camera_stamp_delay] = 0.02;
  const auto late = pictures(truth, 5.0);
  ASSERT_EQ(late.size(), in_time.size());
  for (std::size_t i = 0; i < late.size(); ++i) {
    EXPECT_EQ(late[i].capture_ns, in_time[i].capture_ns + 20'000'000);
    EXPECT_EQ(late[i].arrival_ns, in_time[i].arrival_ns + 20'000'000);
    EXPECT_EQ(late[i].x, in_time[i].x);
  }
}

}  // namespace
}  // namespace odomd::sim::sim_unstated_errors_test
