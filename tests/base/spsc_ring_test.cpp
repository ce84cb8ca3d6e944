// The ring keeps the order, refuses entries when full, and loses none between two threads.
#include "base/spsc_ring.hpp"

#include <memory>
#include <thread>

#include "tests/gtest.hpp"

namespace odomd::spsc_ring_test {
namespace {

TEST(SpscRing, RefusesWhenFullAndOverwritesNothing) {
  SpscRing<int, 4> ring;
  for (int round = 0; round < 10; ++round) {
    EXPECT_TRUE(ring.empty());
    EXPECT_EQ(ring.front(), nullptr);
    for (int i = 0; i < 4; ++i) ASSERT_TRUE(ring.push(i));
    EXPECT_FALSE(ring.push(99));
    for (int i = 0; i < 4; ++i) {
      EXPECT_FALSE(ring.empty());
      ASSERT_NE(ring.front(), nullptr);
      EXPECT_EQ(*ring.front(), i);
      ring.pop();
    }
  }
}

TEST(SpscRing, LosesNothingBetweenTwoThreads) {
  struct Item {
    std::uint64_t number;
    std::uint64_t check;
  };
  constexpr std::uint64_t items = 200'000;
  const auto ring = std::make_unique<SpscRing<Item, 64>>();
  std::thread producer([&] {
    for (std::uint64_t i = 0; i < items;)
      if (ring->push({i, ~i}))
        ++i;
      else
        std::this_thread::yield();
  });
  std::uint64_t wrong = 0;
  for (std::uint64_t i = 0; i < items;) {
    const Item* const item = ring->front();
    if (item == nullptr) {
      std::this_thread::yield();
      continue;
    }
    if (item->number != i || item->check != ~i) ++wrong;
    ring->pop();
    ++i;
  }
  producer.join();
  EXPECT_EQ(wrong, 0U);
  EXPECT_TRUE(ring->empty());
}

}  // namespace
}  // namespace odomd::spsc_ring_test
