// The last poses from which a restarted daemon resumes.
#include "daemon/inheritance.hpp"

#include <gtest/gtest.h>

#include <cstdint>

namespace odomd::daemon::inheritance_test {
namespace {

constexpr std::int64_t now_ns = 1'000'000'000'000;

constexpr std::optional<std::int64_t> age_of(std::int64_t time_ns, odom_mode mode) {
  odom_pose pose{};
  pose.time_ns = time_ns;
  pose.mode = mode;
  return age_to_go_on_from(pose, now_ns);
}

TEST(Inheritance, GoesOnFromAYoungPose) {
  EXPECT_EQ(age_of(now_ns, ODOM_TRACKING), 0);
  EXPECT_EQ(age_of(now_ns - inheritance_ns + 1, ODOM_DEGRADED), inheritance_ns - 1);
  EXPECT_FALSE(age_of(now_ns - inheritance_ns, ODOM_TRACKING));
  EXPECT_FALSE(age_of(now_ns + 1, ODOM_TRACKING));
}

TEST(Inheritance, DoesNotGoOnFromAPoseThatIsNone) {
  EXPECT_FALSE(age_of(now_ns, ODOM_INITIALISING));
  EXPECT_FALSE(age_of(now_ns, ODOM_FAULT));
}

TEST(Inheritance, KnowsTimesFromTheEndsOfTheirRange) {
  // As constant expressions: an overflow does not compile.
  static_assert(!age_of(INT64_MIN, ODOM_TRACKING));
  static_assert(!age_of(INT64_MAX, ODOM_TRACKING));
}

}  // namespace
}  // namespace odomd::daemon::inheritance_test
