// How the simulated sensors and the camera measure the truth.
#include <numbers>
#include <stdexcept>

#include "tests/gtest.hpp"
#include "tests/tools/scratch.hpp"
#include "tools/math/random.hpp"
#include "tools/sim/car/parameters.hpp"
#include "tools/sim/sensors/camera.hpp"
#include "tools/sim/sensors/sensors.hpp"

namespace odomd::sim::sim_sensors_test {
namespace {

using enum Parameter;

ParameterSet ideal() {
  ParameterSet parameters = default_parameters(CarKind::scale_car);
  make_ideal(parameters);
  return parameters;
}

struct Moments {
  double sum = 0.0, squares = 0.0;
  int count = 0;
  void add(double x) {
    sum += x;
    squares += x * x;
    ++count;
  }
  [[nodiscard]] double mean() const { return sum / count; }
  [[nodiscard]] double deviation() const { return std::sqrt(squares / count - mean() * mean()); }
};

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

TEST(Parameters, OneErrorLeavesTheOthersAlone) {
  ParameterSet sizes = default_parameters(CarKind::scale_car);
  const ParameterSet before = draw_truth(sizes, 3);
  sizes[gyro_bias] = 0.0;
  const ParameterSet after = draw_truth(sizes, 3);
  for (const ParameterInfo& info : parameter_table()) {
    if (info.parameter == gyro_bias) continue;
    EXPECT_EQ(before[info.parameter], after[info.parameter]);
  }
}

TEST(Imu, TheBiasWalksAsItsDensitySays) {
  Moments ends;
  for (std::uint64_t seed = 0; seed < 500; ++seed) {
    ParameterSet truth = ideal();
    truth[gyro_bias_walk] = 1e-3;
    Imu imu(truth, seed);
    double last = 0.0;
    for (int k = 0; k < 2000; ++k) last = imu.read({}, {}, 0.005).yaw_rate;
    ends.add(last);
  }
  EXPECT_NEAR(ends.mean(), 0.0, 5e-4);
  EXPECT_NEAR(ends.deviation(), 1e-3 * std::sqrt(10.0), 4e-4);
}

TEST(Imu, ScalesBiasesAndTurnsWhatItFeels) {
  ParameterSet truth = ideal();
  truth[gyro_scale_error] = 0.02;
  truth[gyro_bias] = 0.01;
  truth[accel_bias_x] = 0.3;
  truth[imu_yaw_error] = 0.1;
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

TEST(Imu, VibratesOnTheMove) {
  ParameterSet truth = ideal();
  truth[gyro_noise] = 0.01;
  truth[accel_noise] = 0.2;
  for (const double speed : {0.0, 3.0}) EXPECT_NEAR(noise_at(truth, speed)[0], 0.01, 3e-4);
  truth[noise_at_rest] = 0.2;
  truth[vibration_speed] = 2.0;
  EXPECT_NEAR(noise_at(truth, 0.0)[0], 0.002, 1e-4);
  EXPECT_NEAR(noise_at(truth, 0.0)[1], 0.04, 2e-3);
  EXPECT_NEAR(noise_at(truth, -1.0)[0], 0.006, 2e-4);
  EXPECT_NEAR(noise_at(truth, 5.0)[0], 0.01, 3e-4);
}

TEST(Parameters, SprungCarsHaveTheSensorsThatAreStated) {
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

TEST(WheelEncoder, SpeaksInSteps) {
  ParameterSet truth = ideal();
  truth[wheel_step] = 0.01;
  WheelEncoder encoder(truth, rear_left, 0.3, 1);
  PlantOutput car;
  (void)encoder.read(car, 0.02);
  car.wheel_angle[rear_left] = 1.2345 * 0.02 / 0.3;
  EXPECT_NEAR(encoder.read(car, 0.02), 1.23, 1e-12);
}

TEST(WheelEncoder, QuantisesWithoutDrift) {
  ParameterSet truth = ideal();
  truth[encoder_counts] = 100;
  constexpr double radius = 0.033, cycle = 0.01, speed = 0.9;
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
  ParameterSet truth = ideal();
  truth[steering_offset] = 0.02;
  truth[steering_scale_error] = 0.1;
  PlantOutput car;
  car.steering = 0.1;
  car.commanded_steering = 0.2;
  EXPECT_NEAR(SteeringSensor(truth, 1).read(car), 0.1 * 1.1 + 0.02, 1e-12);
  truth[steering_commanded] = 1.0;
  EXPECT_NEAR(SteeringSensor(truth, 1).read(car), 0.2 * 1.1 + 0.02, 1e-12);
  truth[steering_step] = 0.05;
  EXPECT_NEAR(SteeringSensor(truth, 1).read(car), 0.25, 1e-12);
}

std::vector<estimator::CameraPose> pictures(const ParameterSet& truth,
                                            std::vector<Dropout> dropouts, double seconds) {
  Camera camera(truth, std::move(dropouts), 5);
  std::vector<estimator::CameraPose> poses;
  for (std::int64_t t = 0; t < std::llround(seconds * 1e9); t += 500'000)
    camera.advance(t, {}, t + 500'000, {}, poses);
  return poses;
}

TEST(Camera, IsLateByWhatIsAskedFor) {
  const ParameterSet truth = default_parameters(CarKind::scale_car);
  const auto poses = pictures(truth, {}, 200.0);
  EXPECT_NEAR(static_cast<double>(poses.size()), 200.0 / 0.035, 2.0);
  Moments latency, x, yaw;
  std::int64_t before = 0;
  for (const estimator::CameraPose& pose : poses) {
    const double late = 1e-9 * static_cast<double>(pose.arrival_ns - pose.capture_ns);
    EXPECT_GE(late, 0.03 - 2e-6);
    EXPECT_LE(late, 0.045);
    EXPECT_GT(pose.arrival_ns, before);
    before = pose.arrival_ns;
    latency.add(late);
    x.add(pose.x);
    yaw.add(pose.yaw);
  }
  EXPECT_NEAR(latency.mean(), 0.0375, 5e-4);
  EXPECT_NEAR(x.deviation(), 0.008, 4e-4);
  EXPECT_NEAR(yaw.deviation(), 0.0087, 4e-4);
}

TEST(Camera, StraysAsOftenAndAsFarAsIsAskedFor) {
  ParameterSet truth = ideal();
  truth[camera_outliers] = 0.1;
  const auto poses = pictures(truth, {}, 200.0);
  int outliers = 0;
  for (const estimator::CameraPose& pose : poses) {
    const double error = std::hypot(pose.x, pose.y);
    EXPECT_LE(error, 0.3);
    if (error > 0.0) ++outliers;
  }
  EXPECT_NEAR(static_cast<double>(outliers) / static_cast<double>(poses.size()), 0.1, 0.015);
}

TEST(Camera, DropsOutAndComesBackUnchanged) {
  const ParameterSet truth = default_parameters(CarKind::scale_car);
  const auto all = pictures(truth, {}, 20.0);
  const auto some = pictures(truth, {parse_dropout("5:2.5")}, 20.0);
  EXPECT_NEAR(static_cast<double>(all.size() - some.size()), 2.5 / 0.035, 1.0);
  EXPECT_EQ(all.back().x, some.back().x);
  for (const estimator::CameraPose& pose : some)
    EXPECT_TRUE(pose.capture_ns < 5'000'000'000 || pose.capture_ns >= 7'500'000'000);
  EXPECT_THROW((void)parse_dropout("5"), std::invalid_argument);
  EXPECT_THROW((void)parse_dropout("5:-1"), std::invalid_argument);
}

TEST(Camera, SeesItsReferencePoint) {
  ParameterSet truth = ideal();
  truth[camera_x] = 0.1;
  truth[camera_y] = 0.02;
  truth[camera_yaw] = 0.3;
  Camera camera(truth, {}, 5);
  PlantOutput car;
  car.x = 1.0;
  car.yaw = std::numbers::pi / 2.0;
  std::vector<estimator::CameraPose> poses;
  camera.advance(0, car, 35'000'000, car, poses);
  ASSERT_EQ(poses.size(), 1U);
  EXPECT_NEAR(poses[0].x, 1.0 - 0.02, 1e-12);
  EXPECT_NEAR(poses[0].y, 0.1, 1e-12);
  EXPECT_NEAR(poses[0].yaw, std::numbers::pi / 2.0 + 0.3, 1e-12);
}

}  // namespace
}  // namespace odomd::sim::sim_sensors_test
