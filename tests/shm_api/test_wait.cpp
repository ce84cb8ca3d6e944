// Clients that sleep until the next pose.
#include <sys/syscall.h>
#include <unistd.h>
#include <atomic>
#include <chrono>
#include <thread>

#include "tests/gtest.hpp"
#include "tests/shm_api/segment_fixture.hpp"

namespace odomd::shm::testing::test_wait {
namespace {

constexpr std::int64_t second = 1'000'000'000;

class Wait : public ::testing::Test {
 protected:
  TemporaryDirectory directory;
  std::string path = directory.file("pose");
  Writer writer{{.name = path, .slots = 8}, test_info(second)};
};

bool sleeps(pid_t thread) {
  const std::string line = contents("/proc/self/task/" + std::to_string(thread) + "/stat");
  const std::size_t end_of_name = line.rfind(')');
  return end_of_name != std::string::npos && line.size() > end_of_name + 2 &&
         line[end_of_name + 2] == 'S';
}

/// A client in a thread of its own, asleep until the next pose.
class Waiter {
 public:
  explicit Waiter(const std::string& path)
      : thread_([this, path] {
          const ClientPointer client = open_client(path);
          id_ = static_cast<pid_t>(syscall(SYS_gettid));
          status_ = odom_wait(client.get(), &pose_, sizeof pose_, 60 * second);
          done_ = true;
        }) {
    while (id_ == 0 || !sleeps(id_)) std::this_thread::yield();
  }
  [[nodiscard]] bool is_done() const { return done_; }
  void expect_to_have(std::uint64_t tick) {
    thread_.join();
    EXPECT_EQ(status_, ODOM_OK);
    EXPECT_EQ(pose_.tick, tick);
    EXPECT_TRUE(is_whole(pose_));
  }

 private:
  std::atomic<pid_t> id_{0};
  std::atomic<bool> done_{false};
  odom_status status_ = ODOM_INVALID;
  odom_pose pose_{};
  std::thread thread_;
};

TEST_F(Wait, WakesEveryWaiter) {
  publish_patterned(writer, 1, 100);
  std::array<Waiter, 3> waiters{Waiter(path), Waiter(path), Waiter(path)};
  const std::int64_t published = now_ns();
  publish_patterned(writer, 2, 200);
  writer.wake_clients();
  for (Waiter& waiter : waiters) waiter.expect_to_have(2);
  // Without a wake-up the client would only check after four periods, i.e. four seconds.
  EXPECT_LT(now_ns() - published, 3 * second);
}

// Any process that can read the segment can move the waiters of its futex to another word, because
// Linux requires no write permission. Waiters then miss a wake-up, but check by themselves after
// four periods.
TEST_F(Wait, ChecksAfterFourPeriodsWithoutAWakeUp) {
  const std::string other = directory.file("other");
  Writer quick{{.name = other, .slots = 8}, test_info(second / 20)};
  publish_patterned(quick, 1, 100);
  Waiter waiter(other);
  const std::int64_t published = now_ns();
  publish_patterned(quick, 2, 200);
  for (; !waiter.is_done() && now_ns() - published < 30 * second;
       std::this_thread::sleep_for(std::chrono::milliseconds(10)))
    quick.set_heartbeat(now_ns());
  waiter.expect_to_have(2);
  EXPECT_LT(now_ns() - published, 10 * second) << "long before its time is out";
}

TEST_F(Wait, ReturnsANewerPoseAtOnce) {
  const ClientPointer client = open_client(path);
  publish_patterned(writer, 1, 100);
  odom_pose pose{};
  ASSERT_EQ(odom_latest(client.get(), &pose, sizeof pose), ODOM_OK);
  publish_patterned(writer, 2, 200);
  publish_patterned(writer, 3, 300);
  ASSERT_EQ(odom_wait(client.get(), &pose, sizeof pose, 60 * second), ODOM_OK);
  EXPECT_EQ(pose.tick, 3U);
}

// Tick zero asks for the next pose, not for the newest.
TEST_F(Wait, TimesOut) {
  const ClientPointer client = open_client(path);
  odom_pose pose{};
  EXPECT_EQ(odom_wait(client.get(), &pose, sizeof pose, 1'000'000), ODOM_TIMEOUT);
  publish_patterned(writer, 1, 100);
  EXPECT_EQ(odom_wait(client.get(), &pose, sizeof pose, 0), ODOM_TIMEOUT);
  EXPECT_EQ(pose.tick, 0U);
  ASSERT_EQ(odom_latest(client.get(), &pose, sizeof pose), ODOM_OK);
  EXPECT_EQ(odom_wait(client.get(), &pose, sizeof pose, 1'000'000), ODOM_TIMEOUT);
  EXPECT_EQ(odom_wait(client.get(), &pose, sizeof pose, 0), ODOM_TIMEOUT);
  EXPECT_EQ(pose.tick, 1U);
}

}  // namespace
}  // namespace odomd::shm::testing::test_wait
