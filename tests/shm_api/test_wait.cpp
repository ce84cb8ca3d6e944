// Clients that sleep until the next pose.
#include <fcntl.h>
#include <linux/futex.h>
#include <sys/mman.h>
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

TEST_F(Wait, EveryWaiterIsWoken) {
  struct Waiter {
    std::atomic<pid_t> thread{0};
    odom_status status = ODOM_INVALID;
    odom_pose pose{};
  };
  publish_patterned(writer, 1, 100);
  std::vector<Waiter> waiters(3);
  std::vector<std::thread> threads;
  threads.reserve(waiters.size());
  for (Waiter& waiter : waiters)
    threads.emplace_back([&] {
      const ClientPointer client = open_client(path);
      waiter.thread = static_cast<pid_t>(syscall(SYS_gettid));
      waiter.status = odom_wait(client.get(), &waiter.pose, sizeof waiter.pose, 60 * second);
    });
  for (const Waiter& waiter : waiters)
    while (waiter.thread == 0 || !sleeps(waiter.thread)) std::this_thread::yield();

  const std::int64_t published = now_ns();
  publish_patterned(writer, 2, 200);
  writer.wake_clients();
  for (std::thread& thread : threads) thread.join();
  // Without a wake-up the client would only check after four periods, i.e. four seconds.
  EXPECT_LT(now_ns() - published, 3 * second);
  for (const Waiter& waiter : waiters) {
    EXPECT_EQ(waiter.status, ODOM_OK);
    EXPECT_EQ(waiter.pose.tick, 2U);
    EXPECT_TRUE(is_whole(waiter.pose));
  }
}

// Any process that can read the segment can move the waiters of its futex to another word, because
// Linux requires no write permission. They miss a wake-up then, but check by themselves after four
// periods.
TEST_F(Wait, AReaderWhoTakesTheSleepersAwayDelaysThemByFourPeriods) {
  constexpr std::int64_t period = second / 20;
  const std::string other = directory.file("other");
  Writer quick{{.name = other, .slots = 8}, test_info(period)};
  publish_patterned(quick, 1, 100);
  std::atomic<bool> done{false};
  odom_status status = ODOM_INVALID;
  odom_pose pose{};
  std::thread thread([&] {
    const ClientPointer client = open_client(other);
    status = odom_wait(client.get(), &pose, sizeof pose, 60 * second);
    done = true;
  });

  const int file = open(other.c_str(), O_RDONLY | O_CLOEXEC);
  void* const segment =
      mmap(nullptr, ODOM_WORD_BYTES * ODOM_SEGMENT_HEADER_WORDS, PROT_READ, MAP_SHARED, file, 0);
  close(file);
  EXPECT_NE(segment, MAP_FAILED);
  const auto* const futex = static_cast<const std::uint64_t*>(segment) + ODOM_HEADER_FUTEX;
  std::uint32_t own = 0;
  long moved = 0;
  const std::int64_t deadline = now_ns() + 30 * second;
  while (moved <= 0 && segment != MAP_FAILED && now_ns() < deadline)
    moved = syscall(SYS_futex, futex, FUTEX_CMP_REQUEUE, 0, 1L, &own, 0);
  EXPECT_EQ(moved, 1);
  const std::int64_t taken = now_ns();
  for (std::uint64_t tick = 2; !done && now_ns() - taken < 30 * second; ++tick) {
    publish_patterned(quick, tick, 100 * static_cast<std::int64_t>(tick));
    quick.set_heartbeat(now_ns());
    quick.wake_clients();
    std::this_thread::sleep_for(std::chrono::nanoseconds(period));
  }
  thread.join();
  EXPECT_EQ(status, ODOM_OK);
  // Usually a later tick than 2, but the kernel may wake a waiter without reason.
  EXPECT_GE(pose.tick, 2U);
  EXPECT_LT(now_ns() - taken, 10 * second) << "long before its time is out";
  munmap(segment, ODOM_WORD_BYTES * ODOM_SEGMENT_HEADER_WORDS);
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

// Tick zero asks for the next pose, not for the newest.
TEST_F(Wait, TheTimeRunsOut) {
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
