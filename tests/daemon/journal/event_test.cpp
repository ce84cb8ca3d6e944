#include "daemon/journal/event.hpp"

#include <gtest/gtest.h>

#include <memory>
#include <thread>

namespace odomd::daemon::event_test {
namespace {

TEST(EventRing, HandsEventsOverInTheirOrder) {
  const auto ring = std::make_unique<EventRing>();
  EXPECT_FALSE(ring->next().has_value());
  ring->push({EventKind::overrun, 20, 30});
  ring->push({EventKind::missed, 21, 31});
  const auto first = ring->next();
  ASSERT_TRUE(first.has_value());
  EXPECT_EQ(first->kind, EventKind::overrun);
  EXPECT_EQ(first->a, 20);
  EXPECT_EQ(first->b, 30);
  EXPECT_EQ(ring->next()->kind, EventKind::missed);
  EXPECT_FALSE(ring->next().has_value());
}

TEST(EventRing, DropsAndCountsWhatFindsItFull) {
  const auto ring = std::make_unique<EventRing>();
  constexpr std::int64_t pushed = 1000;
  for (std::int64_t i = 0; i < pushed; ++i) ring->push({EventKind::missed, i, 0});
  std::int64_t read = 0;
  while (const auto event = ring->next()) EXPECT_EQ(event->a, read++);
  EXPECT_EQ(read + static_cast<std::int64_t>(ring->dropped()), pushed);
  EXPECT_GT(ring->dropped(), 0U);
}

TEST(EventRing, LosesNothingBetweenTwoThreads) {
  const auto ring = std::make_unique<EventRing>();
  constexpr std::int64_t pushed = 100'000;
  std::thread beat([&] {
    for (std::int64_t i = 0; i < pushed; ++i) ring->push({EventKind::missed, i, i});
    ring->push({EventKind::suspended, pushed, pushed});
  });
  std::int64_t read = 0;
  std::int64_t last = -1;
  bool ended = false;
  while (!ended) {
    const auto event = ring->next();
    if (!event) {
      // The last event itself may have found the ring full.
      if (read + static_cast<std::int64_t>(ring->dropped()) == pushed + 1) break;
      std::this_thread::yield();
      continue;
    }
    EXPECT_GT(event->a, last);
    EXPECT_EQ(event->b, event->a);
    last = event->a;
    ++read;
    ended = event->kind == EventKind::suspended;
  }
  beat.join();
  EXPECT_EQ(read + static_cast<std::int64_t>(ring->dropped()), pushed + 1);
}

}  // namespace
}  // namespace odomd::daemon::event_test
