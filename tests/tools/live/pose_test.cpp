// odom pose as a command, on the test's own segment.
#include <optional>

#include "tests/tools/own_daemon.hpp"
#include "tests/tools/scratch.hpp"

namespace odomd::tools::pose_test {
namespace {

class PoseCommand : public ::testing::Test {
 protected:
  void publish(std::int64_t period_ns) {
    daemon_.emplace(segment_, period_ns);
    daemon_->pose.x = 1.25;
    daemon_->pose.yaw = 12.3;  // two turns less 15.26 degrees
    daemon_->pose.mode = ODOM_DEGRADED;
    daemon_->pose.conditions = ODOM_COND_BUS_DOWN;
    daemon_->tick();
  }
  Outcome run(const std::string& arguments) const {
    return run_shell("odom pose --shm " + segment_ + " " + arguments);
  }

  static constexpr std::int64_t slow_ns = 1'000'000'000;  // poses stay fresh for four seconds
  Scratch scratch_;
  std::string segment_ = scratch_.path("pose").string();
  std::optional<SlowDaemon> daemon_;
};

TEST_F(PoseCommand, PrintsTheNewestPose) {
  publish(slow_ns);
  const Outcome outcome = run("");
  EXPECT_EQ(outcome.status, 0) << outcome.err;
  EXPECT_THAT(outcome.out,
              AllOf(HasSubstr("● degraded  it works"), HasSubstr("bus_down  a bus is down or gone"),
                    HasSubstr(" 1.250 m"), HasSubstr(" -15.26 °")));
  const auto json = nlohmann::json::parse(run("--json").out);
  EXPECT_EQ(json["x"], 1.25);
  EXPECT_EQ(json["yaw"], 12.3);
  EXPECT_EQ(json["fresh"], true);
  EXPECT_EQ(json["conditions"][0], "bus_down");
}

TEST_F(PoseCommand, OfADeadDaemonIsShownAndFails) {
  publish(100'000);  // stale after 0.4 ms
  const Outcome outcome = run("");
  EXPECT_EQ(outcome.status, 1);
  EXPECT_THAT(outcome.out, HasSubstr(" 1.250 m"));
  EXPECT_THAT(outcome.err, HasSubstr("the daemon has stopped publishing: this was its last pose"));
}

TEST_F(PoseCommand, FollowingEndsWithTheDaemonAndSumsUp) {
  publish(100'000);
  const auto file = scratch_.path("live.csv");
  EXPECT_THAT(run("--follow --until-stale --csv >" + file.string()),
              Ends(0, HasSubstr("odom pose: 0 ticks in")));
  EXPECT_THAT(contents(file), StartsWith("t,x,y,yaw,vx,vy,yaw_rate,"));
}

TEST_F(PoseCommand, FollowingEndsCleanlyOnTerm) {
  publish(slow_ns);
  const auto file = scratch_.path("l.csv").string();
  // Once the header is written, odom pose handles signals.
  EXPECT_THAT(run_shell("odom pose --shm " + segment_ + " --follow --csv >" + file +
                        " & tries=0; while [ ! -s " + file +
                        " ] && [ $tries -lt 200 ]; do sleep 0.1; tries=$((tries + 1)); done; kill "
                        "-TERM $!; wait $!"),
              Ends(0, HasSubstr("odom pose: 0 ticks in")));
}

TEST_F(PoseCommand, OptionsOfFollowingNeedItAndTheLogClockALog) {
  expect_answers(Scratch{}, 2, "odom pose", R"(
--csv -> ; see odom pose --help
--follow --json -> ; see odom pose --help
--until-stale -> ; see odom pose --help
--clock sundial -> ; see odom pose --help
)");
  publish(slow_ns);
  EXPECT_THAT(run("--clock log"), Ends(1, HasSubstr("the daemon is not playing a log")));
}

}  // namespace
}  // namespace odomd::tools::pose_test
