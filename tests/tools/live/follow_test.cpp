// The tools with a running daemon, and without one.
#include <sys/socket.h>
#include <sys/wait.h>
#include <unistd.h>

#include <chrono>
#include <csignal>
#include <memory>

#include "tests/tools/own_daemon.hpp"
#include "tests/tools/scratch.hpp"
#include "tools/live/daemon_feeds.hpp"
#include "tools/live/daemon_link.hpp"
#include "tools/live/tick_follower.hpp"

namespace odomd::tools::follow_test {
namespace {

using std::chrono::milliseconds;

// How the tools find a daemon, and how a recorder notices the end of its connection.

std::string problem_of(const std::string& leaf) {
  try {
    return "found: " + socket_path({}, leaf);
  } catch (const NobodyThere& error) {
    return error.what();
  }
}

TEST(SocketPath, AnErrorNamesAllPlacesUnlessOneIsNamed) {
  ASSERT_EQ(::setenv("XDG_RUNTIME_DIR", "/run/user/4711", 1), 0);
  EXPECT_THAT(problem_of("none.sock"),
              HasSubstr("/run/user/4711/odomd/none.sock, /run/odomd/*/none.sock, "
                        "/run/odomd/none.sock: no such socket; is odomd running?"));
  ASSERT_EQ(::unsetenv("XDG_RUNTIME_DIR"), 0);
  EXPECT_THAT(problem_of("none.sock"), HasSubstr("$XDG_RUNTIME_DIR (not set), /run/odomd/*/"));
  EXPECT_EQ(socket_path("nowhere.sock", "status.sock"), "nowhere.sock");
}

TEST(SocketPath, IsThatOfTheUsersOwnDaemonForEveryCommand) {
  const Scratch runtime;
  std::filesystem::create_directory(runtime.path("odomd"));
  const AnsweringSocket status{runtime.path("odomd/status.sock").string(), R"({"pid": 4711})"};
  const AnsweringSocket recorder{runtime.path("odomd/record.sock").string(), "no recording"};
  const AnsweringSocket camera{runtime.path("odomd/camera.sock").string(), "no camera"};
  const std::string own = "export XDG_RUNTIME_DIR=$PWD; odom ";
  EXPECT_THAT(runtime.must_run(own + "status --json"), HasSubstr("4711"));
  EXPECT_THAT(runtime.run(own + "record").err, HasSubstr("/odomd/record.sock: "));
  EXPECT_THAT(runtime.run(own + "camera send --pose 1,2,3").err, HasSubstr("/odomd/camera.sock: "));
}

TEST(NobodyThere, IsOneSentenceOfEachCommand) {
  const Scratch scratch;
  const std::string path = scratch.path("none").string();
  const std::string segment = path + ": no such segment: is odomd running?\n",
                    other = "? --socket names another path",
                    socket = path + ": no such socket; is odomd running",
                    status = socket + other + " ([status] socket of its configuration)\n";
  for (const auto& [command, says] :
       {std::pair{"pose --shm ", "odom pose: " + segment},
        {"watch --once --socket /nonexistent/s --shm ", "odom watch: " + segment},
        {"watch --once --socket ", "odom watch: " + status},
        {"plot --for 1 --out - --shm ", "odom plot: " + segment},
        {"status --socket ", "odom status: " + status},
        {"camera send --pose 1,2,3 --wait 0.05 --socket ",
         "odom camera send: " + socket + ", with a [camera] table" + other + '\n'},
        {"record --socket ", "odom record: " + socket + other + '\n'}}) {
    const Outcome outcome = run_shell(std::string("odom ") + command + path);
    EXPECT_THAT(outcome, Ends(1, says));
    EXPECT_EQ(outcome.out, "");
  }
  for (const std::string& wrong :
       {std::string("pose --shm nonsense"), std::string("watch --once --shm nonsense"),
        std::string("watch --interval 0"), "status --socket " + std::string(200, 'x')})
    EXPECT_EQ(run_shell("odom " + wrong).status, 2) << wrong;
}

bool runs_at_the_end(RecordingFeed& feed) {
  while (!feed.ended()) EXPECT_FALSE(feed.next(std::chrono::milliseconds(100)).has_value());
  return feed.is_daemon_running();
}

TEST(RecordingFeed, TellsADaemonThatDroppedItFromOneThatHasEnded) {
  const Scratch scratch;
  const std::string path = scratch.path("record.sock").string();
  {
    const FileDescriptor socket = listening_socket(path, SOCK_STREAM);
    RecordingFeed feed(path);
    { const FileDescriptor dropped{::accept(socket.get(), nullptr, nullptr)}; }
    EXPECT_TRUE(runs_at_the_end(feed));
  }
  const std::string other = scratch.path("other.sock").string();
  const pid_t daemon = ::fork();
  if (daemon == 0) {
    const FileDescriptor socket = listening_socket(other, SOCK_STREAM);
    for (;;) ::pause();
  }
  while (!std::filesystem::exists(other)) ::usleep(1000);
  ::usleep(20'000);  // time to listen
  RecordingFeed feed(other);
  ::kill(daemon, SIGKILL);
  EXPECT_FALSE(runs_at_the_end(feed)) << "a zombie does not run";
  ::waitpid(daemon, nullptr, 0);
}

class TickFollowerTest : public ::testing::Test {
 protected:
  TickFollower follower() const {
    return TickFollower{std::move(odom::Client::open(segment_.c_str()).value)};
  }
  // The ticks that one call delivers.
  std::vector<std::uint64_t> follow(TickFollower& follower,
                                    milliseconds timeout = milliseconds{0}) {
    std::vector<std::uint64_t> ticks;
    status_ =
        follower.follow(timeout, [&ticks](const odom_pose& pose) { ticks.push_back(pose.tick); });
    return ticks;
  }

  Scratch scratch_;
  std::string segment_ = scratch_.path("pose").string();
  odom_status status_ = ODOM_OK;
};

TEST_F(TickFollowerTest, HandsOutEveryTickAfterTheFirstLookOnceAndInOrder) {
  SlowDaemon daemon{segment_};
  daemon.tick(1);
  TickFollower follower = this->follower();
  EXPECT_THAT(follow(follower), IsEmpty());
  EXPECT_EQ(status_, ODOM_TIMEOUT);
  daemon.tick(2);
  EXPECT_THAT(follow(follower), ElementsAre(2));
  for (std::uint64_t k = 3; k <= 7; ++k) daemon.tick(k);
  EXPECT_THAT(follow(follower), ElementsAre(3, 4, 5, 6, 7));
  EXPECT_EQ(follower.counts().ticks, 6U);
  EXPECT_EQ(follower.counts().fetched, 4U);
  EXPECT_EQ(follower.counts().lost, 0U);
}

TEST_F(TickFollowerTest, DistinguishesTicksThatTheDaemonMissedFromThoseThatLeftTheHistory) {
  SlowDaemon daemon{segment_, 1'000'000'000, 8};
  daemon.tick(1);
  TickFollower follower = this->follower();
  daemon.tick(4);
  EXPECT_THAT(follow(follower), ElementsAre(4));
  EXPECT_EQ(follower.counts().unpublished, 2U);
  EXPECT_EQ(follower.counts().lost, 0U);

  for (std::uint64_t k = 5; k <= 24; ++k) daemon.tick(k);
  const auto ticks = follow(follower);
  EXPECT_EQ(ticks.back(), 24U);
  EXPECT_EQ(follower.counts().unpublished, 2U);
  EXPECT_EQ(ticks.size() + follower.counts().lost, 20U);
  EXPECT_GE(ticks.size(), 7U);
}

TEST_F(TickFollowerTest, SaysThatTheDaemonIsSilentAndGoesOnWithItsSuccessor) {
  auto daemon = std::make_unique<SlowDaemon>(segment_, 5'000'000);
  daemon->tick(1);
  TickFollower follower = this->follower();
  daemon->tick(2);
  EXPECT_THAT(follow(follower), ElementsAre(2));
  daemon->fall_silent();
  EXPECT_THAT(follow(follower), IsEmpty());
  EXPECT_EQ(status_, ODOM_STALE);

  daemon.reset();
  SlowDaemon successor{segment_};
  for (std::uint64_t k = 4; k <= 6; ++k) successor.tick(k);
  EXPECT_THAT(follow(follower, milliseconds{60'000}), ElementsAre(4, 5, 6));
  EXPECT_EQ(follower.counts().restarts, 1U);
  EXPECT_EQ(follower.counts().lost, 0U);
}

}  // namespace
}  // namespace odomd::tools::follow_test
