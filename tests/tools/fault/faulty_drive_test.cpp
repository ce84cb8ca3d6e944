// The integrity campaign's runs equal those of odom replay, so the results hold for users.
#include <memory>

#include "daemon/core/pipeline.hpp"
#include "tests/campaign/faulty_drive.hpp"
#include "tests/tools/scratch.hpp"
#include "tools/replay/virtual_drive.hpp"

namespace odomd::campaign::faulty_drive_test {
namespace {

using fault::Fault;

class FaultyDriveTest : public ::testing::TestWithParam<Camera> {
 protected:
  static const Drive& drive() {
    static const Drive made = read_drive(
        {.folder = tools::simulate(tools::Scratch{}, "--scenario lap --laps 1 --standstill 1")});
    return made;
  }
  static std::size_t begin() { return drive().ticks * 2 / 5; }

  static Fault from_begin_on(const char* kind) {
    Fault one = fault::fault_of(fault::parse_kind(kind));
    one.begin_s = drive().begin_s(begin());
    return one;
  }

  // Replays the whole drive with the faults that odom fault makes.
  static std::vector<odom_pose> replayed(const std::vector<Fault>& faults) {
    Sent sent = campaign::sent(drive(), faults);
    if (GetParam() == Camera::off) sent.cameras.clear();
    const std::vector<std::string> buses(drive().buses.begin(), drive().buses.end() - 1);
    const auto pipeline = std::make_unique<daemon::Pipeline>(drive().config, drive().databases,
                                                             buses, GetParam() == Camera::on);
    std::vector<odom_pose> poses;
    std::size_t next = 0;
    tools::replay(
        *pipeline, drive().config.realtime.period_ns,
        [&] { return next < sent.frames.size() ? &sent.frames[next++] : nullptr; }, sent.cameras,
        [&](const daemon::TickRecord& record) { poses.push_back(record.pose); });
    return poses;
  }

  // Compares tick by tick what a controller sees, and the position error.
  static void expect_same(const std::vector<Tick>& run, std::size_t first,
                          const std::vector<odom_pose>& poses) {
    std::size_t compared = 0;
    for (const odom_pose& pose : poses) {
      // Delayed frames make the faulty log longer than the drive.
      if (pose.tick < first || pose.tick >= first + run.size()) continue;
      const Tick& tick = run.at(pose.tick - first);
      ASSERT_EQ(tick.mode, pose.mode) << pose.tick;
      ASSERT_EQ(tick.conditions, pose.conditions) << pose.tick;
      ASSERT_EQ(tick.health, pose.health) << pose.tick;
      const auto truth = at(*drive().reference, pose.time_ns);
      if (!truth) continue;
      ASSERT_EQ(tick.position_m, std::hypot(pose.x - truth->pose.x, pose.y - truth->pose.y));
      ++compared;
    }
    EXPECT_GT(compared, (drive().ticks - first) * 9 / 10);
  }
};

TEST_P(FaultyDriveTest, ARunIsTheReplayOfTheLogWithAndWithoutFaults) {
  const FaultyDrive runs(drive(), GetParam(), begin());
  expect_same(runs.healthy(), 0, replayed({}));
  for (const char* kind : {"gyro.stuck", "wheels.noisy", "imu.delayed", "camera.moved"}) {
    SCOPED_TRACE(kind);
    const Fault one = from_begin_on(kind);
    expect_same(runs.with({&one, 1}), begin() + 1, replayed({one}));
  }
  // A run without a source equals a replay in which its frames are lost.
  const Fault lost = from_begin_on("imu.lost");
  expect_same(runs.without(fault::sources_of(lost.kind)), begin() + 1, replayed({lost}));
}

// A wheel slips in the second bend. The others stay trusted; it is trusted again afterwards.
TEST(WheelSlip, IsNamedAndThePoseStaysGood) {
  const Drive drive =
      read_drive({.folder = tools::simulate(tools::Scratch{}, "--scenario lap --laps 1 --seed 5")});
  constexpr std::size_t begin = 2000, ends = 400;  // [ticks]
  constexpr auto slipping = static_cast<std::uint8_t>(estimator::SourceFlag::slipping);
  const FaultyDrive runs(drive, Camera::off, begin);
  for (const char* kind : {"wheel_rear_left.zero:10:2", "wheel_front_right.zero:10:2",
                           "wheel_rear_right.scaled:10:2:1.5", "rear_wheels.scaled:10:2:2"}) {
    SCOPED_TRACE(kind);
    const Fault slip = fault::parse_fault(kind);
    const std::vector<Tick> run = runs.with({&slip, 1});
    for (std::size_t i = 0; i < run.size(); ++i) {
      const Tick& sound = runs.healthy()[begin + 1 + i];
      ASSERT_NEAR(run[i].position_m, sound.position_m, 0.06) << i;
      ASSERT_NEAR(run[i].yaw_rad, sound.yaw_rad, 0.01) << i;
      for (std::size_t source = 0; source < estimator::source_count; ++source) {
        const bool slips =
            fault::contains(fault::sources_of(slip.kind), static_cast<estimator::Source>(source)) &&
            drive.config.can.signals[source].configured;
        if (i < 24 || (slips && i >= ends && i < ends + 210)) continue;  // clears in a second
        ASSERT_EQ(run[i].flags[source], slips && i < ends ? slipping : 0) << i << ' ' << source;
      }
    }
  }
}

INSTANTIATE_TEST_SUITE_P(OfADrive, FaultyDriveTest, ::testing::Values(Camera::off, Camera::on),
                         [](const auto& one) {
                           return one.param == Camera::on ? "WithCamera" : "WithoutCamera";
                         });

}  // namespace
}  // namespace odomd::campaign::faulty_drive_test
