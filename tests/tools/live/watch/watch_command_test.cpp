// odom watch as a command: on the test's own terminal, and into a pipe.
#include <chrono>
#include <memory>
#include <thread>

#include "tests/tools/on_a_terminal.hpp"
#include "tests/tools/own_daemon.hpp"
#include "tests/tools/scratch.hpp"

namespace odomd::tools::watch_command_test {
namespace {

constexpr std::string_view given_back = "\x1b[?7h\x1b[?25h\x1b[0m\x1b[?1049l";

// A daemon that ticks once; its pose is stale after four periods of a second.
std::unique_ptr<SlowDaemon> publish(const std::string& segment) {
  auto daemon = std::make_unique<SlowDaemon>(segment);
  daemon->pose.x = 1.25;
  daemon->pose.mode = ODOM_DEAD_RECKONING;
  daemon->tick();
  return daemon;
}

// A daemon that has stopped ticking; its heartbeat continues while this object exists.
class Beating {
 public:
  explicit Beating(const std::string& segment)
      : daemon_(publish(segment)), thread_([this](const std::stop_token& stop) {
          while (!stop.stop_requested()) {
            daemon_->beat();
            std::this_thread::sleep_for(std::chrono::milliseconds{50});
          }
        }) {}

 private:
  std::unique_ptr<SlowDaemon> daemon_;
  std::jthread thread_;
};

class WatchCommand : public ::testing::Test {
 protected:
  [[nodiscard]] std::string target() const {
    return "--shm " + segment_ + " --socket " + scratch_.path("s").string();
  }
  Scratch scratch_;
  std::string segment_ = scratch_.path("pose").string();
};

TEST_F(WatchCommand, WaitsAttachesGoesOnPausesAndQuits) {
  OnATerminal watch{"watch --interval 0.1 " + target()};
  ASSERT_TRUE(watch.shows("\x1b[?1049h"));
  ASSERT_TRUE(watch.shows("WAITING")) << watch.seen();
  auto daemon = publish(segment_);
  ASSERT_TRUE(watch.shows("1.250")) << watch.seen();
  ASSERT_TRUE(watch.shows("SILENT")) << watch.seen();  // publish() ticked only once
  daemon.reset();
  daemon = publish(segment_);
  ASSERT_TRUE(watch.shows("has restarted 1 time")) << watch.seen();
  watch.press("p");
  ASSERT_TRUE(watch.shows("PAUSED")) << watch.seen();
  watch.press("p");
  ASSERT_TRUE(watch.shows("pause")) << watch.seen();
  watch.press("q");
  EXPECT_EQ(watch.end(), 0);
  EXPECT_THAT(watch.seen(), EndsWith(given_back));
}

TEST_F(WatchCommand, GivesTheTerminalBackOnASignalAndInACrash) {
  for (const auto& [signal, status] :
       {std::pair{SIGINT, 0}, std::pair{SIGTERM, 0}, std::pair{SIGABRT, 128 + SIGABRT}}) {
    OnATerminal watch{"watch --interval 0.1 " + target()};
    ASSERT_TRUE(watch.shows("WAITING")) << watch.seen();
    watch.signal(signal);
    EXPECT_EQ(watch.end(), status);
    EXPECT_THAT(watch.seen(), EndsWith(given_back));
  }
}

TEST_F(WatchCommand, PrintsPlainSnapshotsIntoAPipe) {
  const Beating daemon{segment_};
  const std::string once = must_run("odom watch --once " + target());
  EXPECT_THAT(once, AllOf(HasSubstr("dead_reckoning  odometry alone\n"), HasSubstr("1.250 m"),
                          HasSubstr("no such socket"), Not(HasSubstr("\x1b"))));
  EXPECT_THAT(must_run("odom watch --interval 0.05 " + target() + " | grep -m 2 reckon"),
              HasSubstr("reckoning"));
}

TEST_F(WatchCommand, SaysIntoAPipeThatItWaitsAndEndsWithItsReader) {
  const Outcome piped = run_shell("odom watch --interval 0.05 " + target() + " | head -n 1");
  EXPECT_EQ(piped.err, "odom watch: " + segment_ +
                           ": no such segment: is odomd running? Waiting for it; --once does "
                           "not\n");
  const auto daemon = publish(segment_);
  EXPECT_THAT(
      run_shell("timeout 60 odom watch --interval 0.05 " + target() + " | grep -m 1 SILENT"),
      Ends(0, HasSubstr("the daemon has stopped publishing")));
}

TEST_F(WatchCommand, ShowsTheSegmentOfTheDaemonBehindTheSocket) {
  const std::string socket = scratch_.path("s").string();
  const Beating daemon{segment_};
  const AnsweringSocket status{socket, R"({"shm":")" + segment_ + "\"}"};
  EXPECT_THAT(must_run("odom watch --once --socket " + socket), HasSubstr("1.250 m"));
}

}  // namespace
}  // namespace odomd::tools::watch_command_test
