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
    return guard_->check({.time_ns = time_ns, .id = id, .format = format, .bus = bus}, now);
  }
  std::unique_ptr<StampGuard> guard_ = std::make_unique<StampGuard>();
};

TEST_F(StampGuardTest, TrustsStampsThatRise) {
  for (std::int64_t time = 1; time < 100; ++time)
    EXPECT_EQ(check(now - 100 * ms + time), StampVerdict::trusted);
}

TEST_F(StampGuardTest, GivesEveryStampItsVerdict) {
  using enum StampVerdict;
  for (const auto& [time_ns, verdict] :
       {std::pair{std::int64_t{0}, zero},
        {-5 * ms, zero},
        {now - 5 * ms, trusted},
        {now - 5 * ms, repeated},
        {now - 6 * ms, backwards},
        {now - 4 * ms, trusted},
        {INT64_MAX, future},
        {now - 1 * ms, trusted},  // not moved by the future stamp
        {now + StampGuard::tolerance_ns + 1, future},
        {now + StampGuard::tolerance_ns, trusted}})  // a clock's resolution
    EXPECT_EQ(check(time_ns), verdict) << time_ns;
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
