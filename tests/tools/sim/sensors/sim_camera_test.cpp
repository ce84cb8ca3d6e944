// How the simulated camera sees the truth.
#include <numbers>
#include <stdexcept>

#include "tests/tools/sim/sensors/moments.hpp"
#include "tools/sim/sensors/sensors.hpp"

namespace odomd::sim::sim_camera_test {
namespace {

using enum Parameter;

std::vector<estimator::CameraPose> pictures(const ParameterSet& truth, double seconds,
                                            std::vector<Dropout> dropouts = {}) {
  Camera camera(truth, std::move(dropouts), 5);
  std::vector<estimator::CameraPose> poses;
  for (std::int64_t t = 0; t < std::llround(seconds * 1e9); t += 5'000'000)
    camera.advance(t, {}, t + 5'000'000, {}, poses);
  return poses;
}

TEST(Camera, HasTheConfiguredLatency) {
  const ParameterSet truth = default_parameters(CarKind::scale_car);
  const auto poses = pictures(truth, 200.0);
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

TEST(Camera, HasOutliersAsOftenAndAsLargeAsConfigured) {
  const ParameterSet truth = ideal_parameters({{camera_outliers, 0.1}});
  const auto poses = pictures(truth, 200.0);
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
  const auto all = pictures(truth, 20.0);
  const auto some = pictures(truth, 20.0, {parse_dropout("5:2.5")});
  EXPECT_NEAR(static_cast<double>(all.size() - some.size()), 2.5 / 0.035, 1.0);
  EXPECT_EQ(all.back().x, some.back().x);
  for (const estimator::CameraPose& pose : some)
    EXPECT_TRUE(pose.capture_ns < 5'000'000'000 || pose.capture_ns >= 7'500'000'000);
  EXPECT_THROW((void)parse_dropout("5"), std::invalid_argument);
  EXPECT_THROW((void)parse_dropout("5:-1"), std::invalid_argument);
}

TEST(Camera, SeesItsReferencePoint) {
  const ParameterSet truth =
      ideal_parameters({{camera_x, 0.1}, {camera_y, 0.02}, {camera_yaw, 0.3}});
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

TEST(Camera, HasErrorsWithTheConfiguredCorrelationTime) {
  const ParameterSet truth = ideal_parameters(
      {{camera_lasting_noise, 0.05}, {camera_lasting_yaw_noise, 0.02}, {camera_lasting_time, 2.0}});
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
  // The first pose already has the full error and its sigma.
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
}  // namespace odomd::sim::sim_camera_test
