// How the simulated sensors measure the truth, also with errors that no configuration states:
// latency, dead band, range, warm-up.
#include <cstring>
#include <numbers>

#include "tests/tools/sim/sensors/moments.hpp"
#include "tools/math/random.hpp"
#include "tools/sim/car_bus.hpp"
#include "tools/sim/sensors/sensors.hpp"

namespace odomd::sim::sim_sensors_test {
namespace {

using enum Parameter;

constexpr double radius = 0.033;

TEST(RandomStream, IsNormalAndTheSameForTheSameSeedAndName) {
  RandomStream a(7, "gyro"), b(7, "gyro"), other_name(7, "wheel"), other_seed(8, "gyro");
  Moments moments;
  for (int k = 0; k < 100'000; ++k) {
    const double x = a.normal();
    EXPECT_EQ(x, b.normal());
    EXPECT_NE(x, other_name.normal());
    EXPECT_NE(x, other_seed.normal());
    moments.add(x);
  }
  EXPECT_NEAR(moments.mean(), 0.0, 0.01);
  EXPECT_NEAR(moments.deviation(), 1.0, 0.01);
}

TEST(Parameters, TruthIsDrawnWithTheStatedSizes) {
  const ParameterSet sizes = default_parameters(CarKind::scale_car);
  Moments bias, scale;
  for (std::uint64_t seed = 0; seed < 4000; ++seed) {
    const ParameterSet truth = draw_truth(sizes, seed);
    bias.add(truth[gyro_bias]);
    scale.add(truth[gyro_scale_error]);
    EXPECT_LE(std::abs(truth[gyro_scale_error]), sizes[gyro_scale_error]);
    EXPECT_EQ(truth[camera_noise], sizes[camera_noise]);
  }
  EXPECT_NEAR(bias.deviation(), sizes[gyro_bias], 0.05 * sizes[gyro_bias]);
  EXPECT_NEAR(scale.deviation(), sizes[gyro_scale_error] / std::sqrt(3.0), 0.001);
}

TEST(Parameters, OneErrorLeavesTheOthersUnchanged) {
  ParameterSet sizes = default_parameters(CarKind::scale_car);
  const ParameterSet before = draw_truth(sizes, 3);
  sizes[gyro_bias] = 0.0;
  const ParameterSet after = draw_truth(sizes, 3);
  for (const ParameterInfo& info : parameter_table()) {
    if (info.parameter == gyro_bias) continue;
    EXPECT_EQ(before[info.parameter], after[info.parameter]);
  }
}

TEST(Imu, TheBiasWalksWithTheStatedDensity) {
  Moments ends;
  for (std::uint64_t seed = 0; seed < 500; ++seed) {
    const ParameterSet truth = ideal_parameters({{gyro_bias_walk, 1e-3}});
    Imu imu(truth, seed);
    double last = 0.0;
    for (int k = 0; k < 2000; ++k) last = imu.read({}, {}, 0.005).yaw_rate;
    ends.add(last);
  }
  EXPECT_NEAR(ends.mean(), 0.0, 5e-4);
  EXPECT_NEAR(ends.deviation(), 1e-3 * std::sqrt(10.0), 4e-4);
}

TEST(Imu, AppliesScaleBiasAndMountingYaw) {
  const ParameterSet truth = ideal_parameters(
      {{gyro_scale_error, 0.02}, {gyro_bias, 0.01}, {accel_bias_x, 0.3}, {imu_yaw_error, 0.1}});
  Imu imu(truth, 1);
  PlantOutput car;
  car.yaw_rate = 2.0;
  car.accel_x = 1.0;
  car.accel_y = 3.0;
  const ImuReading reading = imu.read(car, car, 0.005);
  EXPECT_NEAR(reading.yaw_rate, 2.0 * 1.02 + 0.01, 1e-12);
  const double at_x = 1.0 - 4.0 * truth[imu_x], at_y = 3.0 - 4.0 * truth[imu_y];
  EXPECT_NEAR(reading.accel_x, std::cos(0.1) * at_x + std::sin(0.1) * at_y + 0.3, 1e-12);
  EXPECT_NEAR(reading.accel_y, -std::sin(0.1) * at_x + std::cos(0.1) * at_y, 1e-12);
}

// Noise of gyro and accelerometer at a speed (0: at rest).
std::array<double, 2> noise_at(const ParameterSet& truth, double speed) {
  Imu imu(truth, 3);
  Moments gyro, accel;
  PlantOutput car;
  car.v_x = speed;
  for (int k = 0; k < 20'000; ++k) {
    const ImuReading reading = imu.read(car, car, 0.01);
    gyro.add(reading.yaw_rate);
    accel.add(reading.accel_y);
  }
  return {gyro.deviation(), accel.deviation()};
}

TEST(Imu, HasMoreNoiseWhileDriving) {
  ParameterSet truth = ideal_parameters({{gyro_noise, 0.01}, {accel_noise, 0.2}});
  for (const double speed : {0.0, 3.0}) EXPECT_NEAR(noise_at(truth, speed)[0], 0.01, 3e-4);
  truth[noise_at_rest] = 0.2;
  truth[vibration_speed] = 2.0;
  EXPECT_NEAR(noise_at(truth, 0.0)[0], 0.002, 1e-4);
  EXPECT_NEAR(noise_at(truth, 0.0)[1], 0.04, 2e-3);
  EXPECT_NEAR(noise_at(truth, -1.0)[0], 0.006, 2e-4);
  EXPECT_NEAR(noise_at(truth, 5.0)[0], 0.01, 3e-4);
}

TEST(Parameters, SprungCarsHaveTheDocumentedSensors) {
  const ParameterSet sizes = default_parameters(CarKind::ford_escort);
  constexpr double degree = std::numbers::pi / 180.0;
  EXPECT_DOUBLE_EQ(sizes[gyro_noise], 0.1 * degree);
  EXPECT_DOUBLE_EQ(sizes[gyro_bias], 0.3 * degree);
  EXPECT_EQ(sizes[accel_noise], 0.1);
  EXPECT_EQ(sizes[wheel_step], 0.01);
  EXPECT_EQ(sizes[wheel_radius_error_rear_right], 0.005);
  EXPECT_DOUBLE_EQ(sizes[steering_offset], 0.3 * degree);
  EXPECT_EQ(sizes[noise_at_rest], 0.2);
  EXPECT_EQ(sizes[camera_noise], 0.05);
  EXPECT_EQ(default_parameters(CarKind::scale_car)[noise_at_rest], 1.0);
}

TEST(WheelEncoder, RoundsToItsStep) {
  const ParameterSet truth = ideal_parameters({{wheel_step, 0.01}});
  WheelEncoder encoder(truth, rear_left, 0.3, 1);
  PlantOutput car;
  (void)encoder.read(car, 0.02);
  car.wheel_angle[rear_left] = 1.2345 * 0.02 / 0.3;
  EXPECT_NEAR(encoder.read(car, 0.02), 1.23, 1e-12);
}

TEST(WheelEncoder, QuantisesWithoutDrift) {
  const ParameterSet truth = ideal_parameters({{encoder_counts, 100.0}});
  constexpr double cycle = 0.01, speed = 0.9;
  WheelEncoder encoder(truth, rear_left, radius, 1);
  const double count = 2.0 * std::numbers::pi * radius / 100.0;  // distance per encoder count
  PlantOutput car;
  (void)encoder.read(car, cycle);
  double way = 0.0;
  constexpr int cycles = 5000;
  for (int k = 0; k < cycles; ++k) {
    car.wheel_angle[rear_left] += speed * cycle / radius;
    const double read = encoder.read(car, cycle);
    EXPECT_NEAR(std::remainder(read * cycle, count), 0.0, 1e-12);
    way += read * cycle;
  }
  EXPECT_NEAR(way, cycles * speed * cycle, count);
}

TEST(WheelEncoder, AStandingWheelReadsZero) {
  ParameterSet truth = default_parameters(CarKind::scale_car);
  WheelEncoder encoder(truth, front_left, 0.033, 1);
  for (int k = 0; k < 100; ++k) EXPECT_EQ(encoder.read({}, 0.01), 0.0);
}

TEST(SteeringSensor, ReadsTheCommandOrTheWheels) {
  ParameterSet truth = ideal_parameters({{steering_offset, 0.02}, {steering_scale_error, 0.1}});
  PlantOutput car;
  car.steering = 0.1;
  car.commanded_steering = 0.2;
  EXPECT_NEAR(SteeringSensor(truth, 1).read(car), 0.1 * 1.1 + 0.02, 1e-12);
  truth[steering_commanded] = 1.0;
  EXPECT_NEAR(SteeringSensor(truth, 1).read(car), 0.2 * 1.1 + 0.02, 1e-12);
  truth[steering_step] = 0.05;
  EXPECT_NEAR(SteeringSensor(truth, 1).read(car), 0.25, 1e-12);
}

// Parameters with the IMU in the centre of gravity.
ParameterSet level_imu(const std::vector<Assignment>& changes = {}) {
  ParameterSet parameters = ideal_parameters(changes);
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

TEST(Latency, DelaysOneSourceAndLeavesTheOthersUnchanged) {
  const std::array<double, 4> in_time = last_values(level_imu());
  for (const double value : in_time) EXPECT_NEAR(value, 0.49, 0.011);
  constexpr std::array latencies{gyro_latency, accel_latency, wheel_latency, steering_latency};
  for (std::size_t late = 0; late < latencies.size(); ++late) {
    const ParameterSet truth = level_imu({{latencies[late], 0.0803}});
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
  const ParameterSet truth = level_imu({{wheel_dead_band, 0.5}});
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

TEST(WheelEncoder, ReadsTheSpeedOfATurningWheelAtOnce) {
  WheelEncoder encoder(level_imu(), rear_left, radius, 1);
  EXPECT_NEAR(encoder.read({.wheel_rate = {0.0, 0.0, 30.0, 0.0}}, 0.01), 30.0 * radius, 1e-9);
}

TEST(Sensors, SaturateAtTheirRange) {
  const ParameterSet truth =
      level_imu({{gyro_range, 2.0}, {accel_range, 5.0}, {steering_range, 0.3}});
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
  const ParameterSet truth = level_imu({{gyro_drift, -0.02}, {gyro_drift_time, 60.0}});
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

}  // namespace
}  // namespace odomd::sim::sim_sensors_test
