#include "daemon/realtime/relay.hpp"

#include <gtest/gtest.h>

#include <atomic>

namespace odomd::daemon::relay_test {
namespace {

TEST(Relay, WakesAllAfterARing) {
  std::atomic<int> woken{0};
  Relay relay(2, -1, [&] {
    woken.fetch_add(1);
    woken.notify_all();
  });
  for (int ring = 1; ring <= 100; ++ring) {
    const int before = woken.load();
    relay.ring();
    woken.wait(before);
  }
  EXPECT_EQ(woken.load(), 100);
}

TEST(Relay, EndsWithoutEverHavingBeenRung) {
  std::atomic<int> woken{0};
  {
    const Relay relay(2, -1, [&] { woken.fetch_add(1); });
  }
  EXPECT_LE(woken.load(), 1);
}

TEST(Relay, SaysWhatTheMachineRefused) {
  const Relay relay(2, 1023, [] {});
  EXPECT_EQ(relay.grant().cpu, -1);
  ASSERT_FALSE(relay.grant().refusals.empty());
  EXPECT_NE(relay.grant().refusals.front().find("is not pinned to CPU 1023"), std::string::npos);
}

}  // namespace
}  // namespace odomd::daemon::relay_test
