// Each verdict on a time stamp, and which identifiers the guard distinguishes.
#include "can_protocol/sources/stamp_guard.hpp"

#include <memory>

#include "tests/gtest.hpp"

namespace odomd::can::stamp_guard_test {
namespace {

constexpr std::int64_t ms = 1'000'000;
constexpr std::int64_t now = 1'000'000 * ms;

class StampGuardTest : public testing::Test {
 protected:
  StampVerdict check(std::int64_t time_ns, std::uint32_t id = 0x120, std::uint8_t bus = 0,
                     IdFormat format = IdFormat::standard) {
    Frame frame;
    frame.time_ns = time_ns;
    frame.id = id;
    frame.bus = bus;
    frame.format = format;
    return guard_->check(frame, now);
  }
  std::unique_ptr<StampGuard> guard_ = std::make_unique<StampGuard>();
};

TEST_F(StampGuardTest, TrustsStampsThatRise) {
  for (std::int64_t time = 1; time < 100; ++time)
    EXPECT_EQ(check(now - 100 * ms + time), StampVerdict::trusted);
}

TEST_F(StampGuardTest, RefusesZeroAndLess) {
  EXPECT_EQ(check(0), StampVerdict::zero);
  EXPECT_EQ(check(-5 * ms), StampVerdict::zero);
}

TEST_F(StampGuardTest, RefusesTheFutureBeyondAClocksResolution) {
  EXPECT_EQ(check(now + StampGuard::tolerance_ns), StampVerdict::trusted);
  EXPECT_EQ(check(now + StampGuard::tolerance_ns + 1), StampVerdict::future);
}

TEST_F(StampGuardTest, IsNotMovedByAFutureStamp) {
  EXPECT_EQ(check(now - 2 * ms), StampVerdict::trusted);
  EXPECT_EQ(check(INT64_MAX), StampVerdict::future);
  EXPECT_EQ(check(now - 1 * ms), StampVerdict::trusted);
}

TEST_F(StampGuardTest, RefusesBackwardsAndRepeatedWithinOneIdentifier) {
  EXPECT_EQ(check(now - 5 * ms), StampVerdict::trusted);
  EXPECT_EQ(check(now - 5 * ms), StampVerdict::repeated);
  EXPECT_EQ(check(now - 6 * ms), StampVerdict::backwards);
  EXPECT_EQ(check(now - 4 * ms), StampVerdict::trusted);
}

TEST_F(StampGuardTest, KeepsBusesIdentifiersAndFormatsApart) {
  EXPECT_EQ(check(now - 5 * ms, 0x120, 0), StampVerdict::trusted);
  EXPECT_EQ(check(now - 5 * ms, 0x121, 0), StampVerdict::trusted);
  EXPECT_EQ(check(now - 6 * ms, 0x120, 1), StampVerdict::trusted);
  EXPECT_EQ(check(now - 6 * ms, 0x120, 0, IdFormat::extended), StampVerdict::trusted);
  EXPECT_EQ(check(now - 6 * ms, 0x120, 0), StampVerdict::backwards);
}

TEST_F(StampGuardTest, StartsOverWhenTheClockWasSetBack) {
  EXPECT_EQ(check(now), StampVerdict::trusted);
  EXPECT_EQ(check(now - StampGuard::restart_ns), StampVerdict::trusted);
  EXPECT_EQ(check(now - StampGuard::restart_ns + 1), StampVerdict::trusted);
}

TEST_F(StampGuardTest, GoesOnWhenItsTableIsFull) {
  for (std::uint32_t id = 0; id < 20'000; ++id)
    EXPECT_EQ(check(now - 5 * ms, id, 0, IdFormat::extended), StampVerdict::trusted);
  // Identifiers beyond the capacity are still checked for zero and future.
  EXPECT_EQ(check(0, 19'999, 0, IdFormat::extended), StampVerdict::zero);
  EXPECT_EQ(check(now + 100 * ms, 19'999, 0, IdFormat::extended), StampVerdict::future);
  // The first identifiers are kept.
  EXPECT_EQ(check(now - 6 * ms, 0, 0, IdFormat::extended), StampVerdict::backwards);
}

}  // namespace
}  // namespace odomd::can::stamp_guard_test
