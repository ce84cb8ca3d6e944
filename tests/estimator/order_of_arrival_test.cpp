// Late and shuffled samples and skipped ticks give the same bits in the end.
#include <optional>
#include <random>

#include "circle_drive.hpp"
#include "estimator/full_filter.hpp"
#include "tests/gtest.hpp"

namespace odomd::estimator::testing::order_of_arrival_test {
namespace {

TEST(OrderOfArrival, AnyOrderOfArrivalGivesTheSameBitsThroughGatesSlipRestAndReset) {
  const std::vector<Arrival> in_order = eventful_drive();
  constexpr std::int64_t ticks = 800;
  FullFilter reference = started();
  // The drive contains all events.
  std::array<int, source_count> gated{};
  bool stood = false;
  Estimate expected;
  for (std::int64_t k = 1; k <= ticks; ++k) {
    expected = step_to(reference, in_order, k - 1, k);
    stood = stood || expected.mode == Mode::standstill;
    for (const Judgement& judgement : reference.judgements())
      gated[index_of(judgement.source)] += judgement.verdict == Verdict::gated ? 1 : 0;
  }
  ASSERT_TRUE(stood);
  ASSERT_GT(gated[index_of(Source::yaw_rate)], 0);
  ASSERT_GT(gated[index_of(Source::wheel_rear_left)], 10);
  ASSERT_GT(gated[index_of(Source::camera)], 1);
  ASSERT_EQ(expected.reset_count, 2U);
  ASSERT_NEAR(expected.last_jump.y, -2.0, 0.05);

  std::mt19937 random(14);
  for (int permutation = 0; permutation < 5; ++permutation) {
    FullFilter filter = started();
    const std::vector<Arrival> in_any_order =
        shuffled(in_order, start_ns + ticks * period_ns, random);
    const Estimate e = run(filter, in_any_order, ticks).back();
    expect_same_state(e, expected);
    EXPECT_EQ(e.camera_ns, expected.camera_ns);
  }
}

TEST(OrderOfArrival, OrderWithinATickDoesNotChangeEitherFrame) {
  const std::vector<Arrival> in_order = drive_on_a_circle(1'000 * millisecond);
  const std::vector<Estimate> expected = run(in_order, 200);
  std::mt19937 random(12);
  for (int permutation = 0; permutation < 5; ++permutation) {
    std::vector<Arrival> arrivals = in_order;
    std::ranges::shuffle(arrivals, random);
    std::ranges::stable_sort(arrivals, {}, [](const Arrival& a) { return tick_of(a.arrival_ns); });
    const std::vector<Estimate> estimates = run(arrivals, 200);
    for (std::size_t i = 0; i < estimates.size(); ++i)
      expect_same_frames(estimates[i], expected[i]);
  }
}

TEST(OrderOfArrival, TheSameOfTwoDuplicatesCountsInAnyOrder) {
  const std::vector<Arrival> arrivals = drive_on_a_circle(500 * millisecond);
  const std::int64_t taken = start_ns + 390 * millisecond + 1;
  const Measurement one{Source::yaw_rate, taken, 1.02, 0.005};
  const Measurement other{Source::yaw_rate, taken, 0.97, 0.005};
  const CameraPose here{taken, 0, 0.72, 0.15, 0.39, 0.008, 0.008, 0.009};
  const CameraPose there{taken, 0, 0.71, 0.16, 0.39, 0.008, 0.008, 0.009};

  // Adds both samples in one tick, or the second one after the first has been fused.
  for (const int ticks_between : {0, 5}) {
    // Two poses at one time come from two cameras, and are not duplicates.
    const auto end_with = [&](const auto& first, const auto& second,
                              std::optional<Verdict> verdict) {
      FullFilter filter = started();
      (void)run(filter, arrivals, 79);
      EXPECT_EQ(filter.add(first), std::nullopt);
      for (int i = 0; i < ticks_between; ++i) (void)filter.step(start_ns + (80 + i) * period_ns);
      EXPECT_EQ(filter.add(second), verdict);
      return filter.step(start_ns + 90 * period_ns);
    };
    expect_same_state(end_with(one, other, Verdict::duplicate),
                      end_with(other, one, Verdict::duplicate));
    expect_same_state(end_with(here, there, std::nullopt), end_with(there, here, std::nullopt));
  }
}

TEST(OrderOfArrival, SkippedTicksLeaveTheSameBitsOnceTheirSamplesAreThere) {
  const std::vector<Arrival> arrivals = drive_on_a_circle(1'000 * millisecond);
  const Estimate expected = run(arrivals, 180).back();
  FullFilter some = started();
  std::int64_t before = 0;
  Estimate last;
  for (const std::int64_t tick : {1, 2, 3, 10, 11, 25, 60, 61, 100, 140, 180})
    last = step_to(some, arrivals, std::exchange(before, tick), tick);
  expect_same_state(last, expected);
}

TEST(OrderOfArrival, TheOdometryFrameOfSkippedTicksIsThatOfEveryTick) {
  const std::vector<Arrival> arrivals = drive_on_a_circle(500 * millisecond);
  FullFilter every = started();
  FullFilter some = started();
  (void)run(some, arrivals, 120);
  // There are no more samples, and the predicted car leaves its circle.
  expect_same_frames(some.step(start_ns + 240 * period_ns), run(every, arrivals, 240).back());
}

TEST(OrderOfArrival, BitsDoNotDependOnTheEpoch) {
  // The same drive decades later, on the grid of the ticks.
  constexpr std::int64_t later_ns = 1'760'000'000'000'000'000;
  const std::vector<Arrival> arrivals = drive_on_a_circle(500 * millisecond);
  const std::vector<Estimate> expected = run(arrivals, 100);
  std::vector<Arrival> later = arrivals;
  for (auto& [arrival_ns, signal, camera] : later) {
    (signal ? signal->time_ns : camera->capture_ns) += later_ns;
    (signal ? signal->arrival_ns : camera->arrival_ns) += later_ns;
  }
  FullFilter filter = started();
  for (std::size_t i = 0, k = 0; k < expected.size(); ++k) {
    const std::int64_t now = expected[k].time_ns;
    for (; i < later.size() && later[i].arrival_ns <= now; ++i)
      (void)(later[i].signal ? filter.add(*later[i].signal) : filter.add(*later[i].camera));
    expect_same_frames(filter.step(now + later_ns), expected[k]);
  }
}

}  // namespace
}  // namespace odomd::estimator::testing::order_of_arrival_test
