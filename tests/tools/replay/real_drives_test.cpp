// The recorded drives, each with its configuration, through the pipeline.
#include <memory>
#include <optional>

#include "daemon/core/pipeline.hpp"
#include "tests/gtest.hpp"
#include "tests/recorded_drives.hpp"
#include "tools/replay/drive.hpp"
#include "tools/replay/virtual_drive.hpp"

namespace odomd::tools::real_drives_test {
namespace {

using estimator::Model;

/// `full` comes first: it is the model that cars use.
constexpr std::array models{Model::full, Model::inertial, Model::paper, Model::kinematic,
                            Model::kinematic_printed};
static_assert(models.size() == estimator::model_names.size());

std::vector<odom_pose> replayed(const Drive& drive, Model model, bool with_camera) {
  daemon::Config config = drive.config;
  config.model = model;
  const auto pipeline =
      std::make_unique<daemon::Pipeline>(config, drive.databases, drive.buses, with_camera);
  std::vector<estimator::CameraPose> cameras;
  if (with_camera) cameras = drive.cameras;
  auto frame = drive.frames.begin();
  std::vector<odom_pose> poses;
  replay(
      *pipeline, config.realtime.period_ns,
      [&] { return frame == drive.frames.end() ? nullptr : &*frame++; }, cameras,
      [&](const daemon::TickRecord& record) { poses.push_back(record.pose); });
  return poses;
}

void expect_sound(const std::vector<odom_pose>& poses, const std::string& what) {
  ASSERT_GT(poses.size(), 1000U) << what;
  for (std::size_t i = 1; i < poses.size(); ++i) {
    const odom_pose& p = poses[i];
    ASSERT_EQ(p.time_ns, poses[i - 1].time_ns + 5'000'000) << what;
    ASSERT_TRUE(std::isfinite(p.x + p.y + p.yaw + p.vx + p.vy + p.yaw_rate)) << what;
    ASSERT_TRUE(std::isfinite(p.odom_x + p.odom_y + p.odom_yaw)) << what;
    ASSERT_TRUE(std::isfinite(p.vx_dot + p.vy_dot + p.yaw_accel)) << what;
    ASSERT_TRUE(std::ranges::all_of(p.covariance, [](double v) { return std::isfinite(v); }))
        << what;
    ASSERT_GT(p.covariance[0], 0.0) << what;
    ASSERT_GT(p.covariance[3], 0.0) << what;
    ASSERT_GT(p.covariance[5], 0.0) << what;
  }
}

/// The paper's model faults for good if the car reverses; the others never fault.
void expect_no_fault(const std::vector<odom_pose>& poses, Model model, const std::string& what) {
  const auto fault = std::ranges::find(poses, ODOM_FAULT, &odom_pose::mode);
  if (fault == poses.end()) return;
  ASSERT_EQ(model, Model::paper) << what << ": at " << fault->time_ns;
  ASSERT_NE(fault, poses.begin()) << what;
  EXPECT_LT(std::prev(fault)->vx, 0.0) << what;
}

Drive read(const std::string& name) {
  return read_drive({.folder = recorded::folder(name), .config = recorded::config(name)});
}

class RealDrives : public testing::Test {
 protected:
  void SetUp() override {
    std::vector<std::string> names(recorded::drives.begin(), recorded::drives.end());
    names.insert(names.end(), recorded::drives_with_config.begin(),
                 recorded::drives_with_config.end());
    if (recorded::at_hand(names.size())) names_ = names;
  }
  std::vector<std::string> names_;
};

TEST_F(RealDrives, ReplayThroughEveryModel) {
  for (const std::string& name : names_) {
    const Drive drive = read(name);
    for (const Model model : models) {
      for (const bool with_camera : {false, true}) {
        if (with_camera && drive.cameras.empty()) continue;  // rav4 and xray_duck_1 have none
        const std::string what = name + ", " + std::string(daemon::name_of(model)) +
                                 (with_camera ? ", with camera" : "");
        const auto poses = replayed(drive, model, with_camera);
        expect_sound(poses, what);
        expect_no_fault(poses, model, what);
      }
    }
  }
}

/// Median distance between the camera poses of the drive's second half and the estimated poses at
/// the same times, until the model stops.
std::optional<double> median_distance(const std::vector<odom_pose>& poses,
                                      const std::vector<estimator::CameraPose>& cameras) {
  std::vector<double> distances;
  for (std::size_t i = cameras.size() / 2; i < cameras.size(); ++i) {
    const auto tick = (cameras[i].capture_ns - poses.front().time_ns) / 5'000'000;
    if (tick < 0 || tick >= static_cast<std::int64_t>(poses.size())) continue;
    const odom_pose& pose = poses[static_cast<std::size_t>(tick)];
    if (pose.mode == ODOM_FAULT) break;  // the car has reversed: the model says so and stops
    distances.push_back(std::hypot(cameras[i].x - pose.x, cameras[i].y - pose.y));
  }
  if (distances.empty()) return std::nullopt;
  const auto middle = distances.begin() + static_cast<std::ptrdiff_t>(distances.size() / 2);
  std::nth_element(distances.begin(), middle, distances.end());
  return *middle;
}

TEST_F(RealDrives, StayWithTheirCamera) {
  for (const std::string& name : names_) {
    // The wheels spin at five times the car's speed: odometry cannot bridge even 40 ms then.
    if (name == "dart_drift1") continue;
    const Drive drive = read(name);
    if (drive.cameras.empty()) continue;  // rav4 and xray_duck_1 have none
    for (const Model model : {Model::full, Model::inertial, Model::paper}) {
      const std::string what = name + ", " + std::string(daemon::name_of(model));
      const auto distance = median_distance(replayed(drive, model, true), drive.cameras);
      ASSERT_TRUE(distance) << what;
      EXPECT_LT(*distance, 10 * drive.cameras.front().sigma_x) << what;
    }
  }
}

TEST_F(RealDrives, DoNotFollowATrackerThatHasLostTheCar) {
  if (names_.empty()) return;
  // From 4 s to 17.6 s the tracker repeats one position, with jitter, while the car drives 14 m.
  const Drive drive = read("dart_track_v1");
  const auto poses = replayed(drive, Model::full, true);
  expect_sound(poses, drive.name);
  for (const odom_pose& pose : poses) ASSERT_EQ(pose.reset_count, 1U) << pose.time_ns;
  const auto found = std::adjacent_find(
      drive.cameras.rbegin(), drive.cameras.rend(),
      [](const auto& later, const auto& earlier) { return std::abs(later.x - earlier.x) > 1.0; });
  ASSERT_NE(found, drive.cameras.rend());
  const auto tick =
      static_cast<std::size_t>((found->capture_ns - poses.front().time_ns) / 5'000'000);
  ASSERT_LT(tick, poses.size());
  EXPECT_LT(std::hypot(found->x - poses[tick].x, found->y - poses[tick].y),
            0.2);  // 1.4 % of the distance
  EXPECT_LT(std::abs(std::remainder(found->yaw - poses[tick].yaw, 6.283185307179586)), 0.08);
}

}  // namespace
}  // namespace odomd::tools::real_drives_test
