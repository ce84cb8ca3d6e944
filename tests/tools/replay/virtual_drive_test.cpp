#include "tools/replay/virtual_drive.hpp"

#include <memory>

#include "daemon/core/pipeline.hpp"
#include "tests/daemon/core/one_wheel.hpp"
#include "tests/gtest.hpp"
#include "tools/replay/replay_checks.hpp"

namespace odomd::tools::virtual_drive_test {
namespace {

constexpr std::int64_t ms = 1'000'000;
constexpr std::int64_t period = 5 * ms;

std::unique_ptr<daemon::Pipeline> pipeline(bool camera_expected) {
  daemon::Config config;
  config.model = estimator::Model::kinematic;
  config.can.bindings = daemon::one_wheel::bindings();
  return std::make_unique<daemon::Pipeline>(config, daemon::one_wheel::bus(),
                                            std::vector<std::string>{"can0"}, camera_expected);
}

struct Drive {
  std::vector<std::int64_t> stamps;
  std::vector<estimator::CameraPose> cameras;
  std::vector<odom_pose> poses;
  ReplaySummary summary;
};

void play(Drive& drive) {
  std::size_t next = 0;
  can::Frame frame{.id = 257, .length = 2};
  frame.data[0] = 0xE8;  // 1 m/s
  frame.data[1] = 0x03;
  const auto frames = [&]() -> const can::Frame* {
    if (next == drive.stamps.size()) return nullptr;
    frame.time_ns = drive.stamps[next++];
    return &frame;
  };
  const auto p = pipeline(!drive.cameras.empty());
  drive.summary = replay(*p, period, frames, drive.cameras, [&](const daemon::TickRecord& record) {
    drive.poses.push_back(record.pose);
  });
}

TEST(FirstTick, RoundsUpToAMultipleOfThePeriod) {
  EXPECT_EQ(first_tick_ns(1'760'000'000'069'964'000, period), 1'760'000'000'070'000'000);
  EXPECT_EQ(first_tick_ns(1'760'000'000'070'000'000, period), 1'760'000'000'070'000'000);
  EXPECT_EQ(first_tick_ns(1, period), period);
}

TEST(Replay, UsesAFrameAtTheFirstTickNotBeforeItsStamp) {
  Drive drive{.stamps = {1001 * ms, 1005 * ms, 1005 * ms + 1, 1020 * ms}};
  play(drive);
  EXPECT_EQ(drive.summary.first_tick_ns, 1005 * ms);
  EXPECT_EQ(drive.summary.last_tick_ns, 1020 * ms);
  EXPECT_EQ(drive.summary.frames, 4U);
  EXPECT_EQ(drive.summary.ticks, 4U);
  ASSERT_EQ(drive.poses.size(), 4U);
  for (std::size_t i = 0; i < drive.poses.size(); ++i) {
    EXPECT_EQ(drive.poses[i].tick, i);
    EXPECT_EQ(drive.poses[i].time_ns, 1005 * ms + static_cast<std::int64_t>(i) * period);
  }
}

TEST(Replay, UsesACameraPoseOnceItHasArrived) {
  Drive drive{.stamps = {1000 * ms, 1010 * ms, 1020 * ms, 1030 * ms}};
  drive.cameras = {{.capture_ns = 1000 * ms,
                    .arrival_ns = 1016 * ms,
                    .x = 7.0,
                    .sigma_x = 0.01,
                    .sigma_y = 0.01,
                    .sigma_yaw = 0.01}};
  play(drive);
  EXPECT_EQ(drive.summary.cameras, 1U);
  ASSERT_FALSE(drive.poses.empty());
  EXPECT_EQ(drive.poses.front().time_ns, 1020 * ms);  // initialised by this camera pose
  EXPECT_NEAR(drive.poses.front().x, 7.0, 0.05);
}

TEST(Replay, HasNoTickWithoutFrames) {
  Drive drive{.cameras = {{.capture_ns = 1000 * ms, .arrival_ns = 1016 * ms}}};
  play(drive);
  EXPECT_EQ(drive.summary.ticks, 0U);
  EXPECT_EQ(drive.summary.cameras_after, 1U);
}

TEST(Replay, CountsFramesThatAreFarBehindTheirTick) {
  Drive drive{.stamps = {5000 * ms, 4990 * ms, 4000 * ms, 3000 * ms, 5010 * ms}};
  play(drive);
  EXPECT_EQ(drive.summary.late, 2U);
  EXPECT_EQ(drive.summary.frames, 5U);
}

std::vector<std::string> warnings_after(std::uint64_t ticks, std::uint32_t conditions,
                                        odom_mode mode) {
  const auto idle = pipeline(false);
  ReplaySummary summary;
  const daemon::TickRecord record{
      .pose = {.mode = static_cast<std::uint32_t>(mode), .conditions = conditions}};
  for (std::uint64_t i = 0; i < ticks; ++i) summary.add_tick(*idle, record, 10'000 * ms);
  summary.ticks = 2000;
  return texts_of(check_sources(idle->decoder(), summary));
}

TEST(Replay, WarnsOfWhatTheFilterHasNotLearntForASecond) {
  EXPECT_THAT(warnings_after(300, ODOM_COND_BIAS_UNLEARNT, ODOM_DEAD_RECKONING),
              ElementsAre("yaw_rate: the gyro's bias is not known (for 1.5 of 10.0 s); let the car "
                          "stand for 2 s [W320]"));
  EXPECT_THAT(warnings_after(100, ODOM_COND_BIAS_UNLEARNT, ODOM_DEAD_RECKONING), IsEmpty());
  EXPECT_THAT(warnings_after(300, ODOM_COND_BIAS_UNLEARNT, ODOM_STANDSTILL), IsEmpty());
  EXPECT_THAT(
      warnings_after(300, ODOM_COND_SCALE_IMPLAUSIBLE, ODOM_STANDSTILL),
      ElementsAre("calibrations: a learnt scale is far from its configured value (for 1.5 of 10.0 "
                  "s); check scale and radius under [can.signals], and [vehicle] [W321]"));
}

}  // namespace
}  // namespace odomd::tools::virtual_drive_test
