// Clients that sleep until the next pose.
#include <gtest/gtest.h>
#include <sys/syscall.h>
#include <unistd.h>
#include <atomic>
#include <fstream>
#include <thread>
#include <vector>

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
  std::ifstream file("/proc/self/task/" + std::to_string(thread) + "/stat");
  const std::string line((std::istreambuf_iterator<char>(file)), {});
  const std::size_t end_of_name = line.rfind(')');
  return end_of_name != std::string::npos && line.size() > end_of_name + 2 &&
         line[end_of_name + 2] == 'S';
}

TEST_F(Wait, EveryWaiterIsWoken) {
  struct Waiter {
    std::atomic<pid_t> thread{0};
    odom_status status = ODOM_INVALID;
    odom_pose pose{};
    std::int64_t took_ns = 0;
  };
  publish_patterned(writer, 1, 100);
  std::vector<Waiter> waiters(3);
  std::vector<std::thread> threads;
  threads.reserve(waiters.size());
  for (Waiter& waiter : waiters)
    threads.emplace_back([&] {
      const ClientPointer client = open_client(path);
      waiter.thread = static_cast<pid_t>(syscall(SYS_gettid));
      const std::int64_t start = now_ns();
      waiter.status = odom_wait(client.get(), &waiter.pose, sizeof waiter.pose, 60 * second);
      waiter.took_ns = now_ns() - start;
    });
  for (const Waiter& waiter : waiters)
    while (waiter.thread == 0 || !sleeps(waiter.thread)) std::this_thread::yield();

  const std::int64_t published = now_ns();
  publish_patterned(writer, 2, 200);
  writer.wake_clients();
  for (std::thread& thread : threads) thread.join();
  // By itself a waiter looks up only every four periods, four seconds here.
  EXPECT_LT(now_ns() - published, 3 * second);
  for (const Waiter& waiter : waiters) {
    EXPECT_EQ(waiter.status, ODOM_OK);
    EXPECT_EQ(waiter.pose.tick, 2U);
    EXPECT_TRUE(is_whole(waiter.pose));
  }
}

TEST_F(Wait, ANewerPoseThatIsThereAlreadyIsTaken) {
  const ClientPointer client = open_client(path);
  publish_patterned(writer, 1, 100);
  odom_pose pose{};
  ASSERT_EQ(odom_latest(client.get(), &pose, sizeof pose), ODOM_OK);
  publish_patterned(writer, 2, 200);
  publish_patterned(writer, 3, 300);
  ASSERT_EQ(odom_wait(client.get(), &pose, sizeof pose, 60 * second), ODOM_OK);
  EXPECT_EQ(pose.tick, 3U);
}

TEST_F(Wait, TheTimeRunsOut) {
  const ClientPointer client = open_client(path);
  odom_pose pose{};
  EXPECT_EQ(odom_wait(client.get(), &pose, sizeof pose, 1'000'000), ODOM_TIMEOUT);
  publish_patterned(writer, 1, 100);
  ASSERT_EQ(odom_latest(client.get(), &pose, sizeof pose), ODOM_OK);
  EXPECT_EQ(odom_wait(client.get(), &pose, sizeof pose, 1'000'000), ODOM_TIMEOUT);
  EXPECT_EQ(odom_wait(client.get(), &pose, sizeof pose, 0), ODOM_TIMEOUT);
  EXPECT_EQ(pose.tick, 1U);
}

TEST_F(Wait, TickZeroAsksForTheNextOneNotForTheNewest) {
  const ClientPointer client = open_client(path);
  publish_patterned(writer, 1, 100);
  odom_pose pose{};
  EXPECT_EQ(odom_wait(client.get(), &pose, sizeof pose, 0), ODOM_TIMEOUT);
  EXPECT_EQ(pose.tick, 0U);
}

}  // namespace
}  // namespace odomd::shm::testing::test_wait
