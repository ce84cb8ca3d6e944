// The window of samples: its order, duplicates, and dropped samples.
#include "estimator/ekf/sample_window.hpp"

#include <limits>
#include <random>
#include <tuple>

#include "tests/gtest.hpp"

namespace odomd::estimator::full::sample_window_test {
namespace {

constexpr std::int64_t earliest = std::numeric_limits<std::int64_t>::min();

Sample sample(std::int64_t time_ns, Source source = Source::yaw_rate, double value = 0.0,
              double sigma = 0.1) {
  return {.time_ns = time_ns, .source = source, .value = {value}, .sigma = {sigma}};
}

bool is_same(const Sample& a, const Sample& b) {
  return std::tie(a.time_ns, a.source, a.value, a.sigma) ==
         std::tie(b.time_ns, b.source, b.value, b.sigma);
}

std::vector<std::int64_t> times(SampleWindow& window) {
  std::vector<std::int64_t> times;
  for (const Sample& s : window.after(earliest)) times.push_back(s.time_ns);
  return times;
}

TEST(SampleWindow, KeepsTheOrderOfTimesInAnyOrderOfArrival) {
  std::vector<Sample> in_order;
  for (std::int64_t i = 0; i < 300; ++i)
    in_order.push_back(sample(i / 3, static_cast<Source>(i % 3), static_cast<double>(i)));
  std::mt19937 random(3);
  for (int permutation = 0; permutation < 20; ++permutation) {
    std::vector<Sample> shuffled = in_order;
    std::ranges::shuffle(shuffled, random);
    SampleWindow window;
    for (const Sample& s : shuffled) ASSERT_EQ(window.insert(s), Insertion::inserted);
    EXPECT_TRUE(std::ranges::equal(window.after(earliest), in_order, is_same));
  }
}

TEST(SampleWindow, KeepsTheSameOfTwoDuplicatesInEitherOrder) {
  const std::vector<Sample> claims{sample(5, Source::motor, 1.0, 0.1),
                                   sample(5, Source::motor, 2.0, 0.1),
                                   sample(5, Source::motor, 1.0, 0.2)};
  const auto kept_of = [](const Sample& first, const Sample& second) {
    SampleWindow window;
    window.insert(sample(4, Source::motor));
    window.insert(sample(5, Source::yaw_rate));
    window.insert(first);
    const Insertion insertion = window.insert(second);
    EXPECT_EQ(insertion, second < first ? Insertion::replaced : Insertion::duplicate);
    const auto all = window.after(earliest);
    EXPECT_EQ(all.size(), 3U);
    return all.back();
  };
  for (const Sample& a : claims) {
    for (const Sample& b : claims) EXPECT_TRUE(is_same(kept_of(a, b), kept_of(b, a)));
  }
}

TEST(SampleWindow, AReplacingSampleTakesOverTheVerdict) {
  SampleWindow window;
  window.insert(sample(5, Source::motor, 2.0));
  window.after(earliest).front().judged = true;
  ASSERT_EQ(window.insert(sample(5, Source::motor, 1.0)), Insertion::replaced);
  EXPECT_EQ(window.after(earliest).front().value[0], 1.0);
  EXPECT_TRUE(window.after(earliest).front().judged);
}

TEST(SampleWindow, UntilAndAfterSplitTheWindow) {
  SampleWindow window;
  for (const std::int64_t t : {30, 10, 20}) window.insert(sample(t));
  EXPECT_EQ(window.until(9).size(), 0U);
  EXPECT_EQ(window.after(9).size(), 3U);
  EXPECT_EQ(window.until(20).size(), 2U);
  EXPECT_EQ(window.after(20).size(), 1U);
  EXPECT_EQ(window.after(20).front().time_ns, 30);
  EXPECT_EQ(window.until(std::numeric_limits<std::int64_t>::max()).size(), 3U);
}

TEST(SampleWindow, ForgetsOnEitherSide) {
  SampleWindow window;
  for (std::int64_t t = 1; t <= 9; ++t) window.insert(sample(t));
  window.forget_until(3);
  window.forget_after(7);
  EXPECT_EQ(times(window), (std::vector<std::int64_t>{4, 5, 6, 7}));
  EXPECT_EQ(window.insert(sample(3)), Insertion::inserted);
  EXPECT_EQ(window.dropped_until_ns(), earliest);
}

TEST(SampleWindow, DropsTheOldestWhenFull) {
  SampleWindow window;
  const auto capacity = static_cast<std::int64_t>(SampleWindow::capacity);
  for (std::int64_t t = 1; t <= capacity; ++t)
    ASSERT_EQ(window.insert(sample(10 * t)), Insertion::inserted);
  EXPECT_EQ(window.dropped_until_ns(), earliest);
  // A duplicate drops nothing.
  EXPECT_EQ(window.insert(sample(10 * capacity)), Insertion::duplicate);
  EXPECT_EQ(window.insert(sample(10, Source::yaw_rate, -1.0)), Insertion::replaced);
  EXPECT_EQ(window.dropped_until_ns(), earliest);

  EXPECT_EQ(window.insert(sample(15)), Insertion::inserted);
  EXPECT_EQ(window.dropped_until_ns(), 10);
  EXPECT_EQ(times(window).size(), SampleWindow::capacity);
  EXPECT_EQ(times(window).front(), 15);
  // The new sample is the oldest.
  EXPECT_EQ(window.insert(sample(12)), Insertion::dropped);
  EXPECT_EQ(window.dropped_until_ns(), 12);
  EXPECT_EQ(times(window).front(), 15);
}

TEST(SampleWindow, CountsSamplesDroppedWithoutAVerdict) {
  SampleWindow window;
  constexpr auto capacity = static_cast<std::int64_t>(SampleWindow::capacity);
  for (std::int64_t t = 1; t <= capacity; ++t)
    window.insert(sample(t, t % 4 == 0 ? Source::motor : Source::yaw_rate));
  for (Sample& s : window.after(capacity / 2)) s.judged = true;
  // The first half has no verdict yet, the second half has. The refused sample does not count.
  for (std::int64_t t = capacity + 1; t <= 2 * capacity; ++t) window.insert(sample(t));
  EXPECT_EQ(window.insert(sample(0)), Insertion::dropped);
  const std::array<std::uint32_t, source_count> counts = window.take_dropped();
  EXPECT_EQ(counts[index_of(Source::motor)], capacity / 2 / 4);
  EXPECT_EQ(counts[index_of(Source::yaw_rate)], capacity / 2 / 4 * 3);
  EXPECT_THAT(window.take_dropped(), ::testing::Each(0U)) << "each is reported once";
}

TEST(SampleWindow, WorksIndefinitelyInItsFixedMemory) {
  // Compares far more samples than the window has room for, some of them late, with a sorted list.
  SampleWindow window;
  std::vector<std::int64_t> expected;
  std::mt19937 random(5);
  for (std::int64_t t = 0; t < 20'000; ++t) {
    const std::int64_t late = 2 * t + 1 - 2 * static_cast<std::int64_t>(random() % 50);
    const std::int64_t time = random() % 3 == 0 ? late : 2 * t;
    if (window.insert(sample(time)) == Insertion::inserted)
      expected.insert(std::ranges::upper_bound(expected, time), time);
    window.forget_until(2 * t - 500);
    std::erase_if(expected, [&](std::int64_t other) { return other <= 2 * t - 500; });
    if (t % 97 == 0) {
      ASSERT_EQ(times(window), expected) << t;
    }
  }
  ASSERT_EQ(times(window), expected);
}

}  // namespace
}  // namespace odomd::estimator::full::sample_window_test
