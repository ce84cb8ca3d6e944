#include "daemon/realtime/surroundings.hpp"

#include <gtest/gtest.h>

namespace odomd::daemon::surroundings_test {
namespace {

constexpr std::int64_t second = 1'000'000'000;

TEST(Surroundings, AreQuietWhereNothingIsWrong) {
  Surroundings surroundings(0);
  EXPECT_EQ(surroundings.conditions({.now_ns = second}), 0U);
}

TEST(Surroundings, ReportWhatHoldsNow) {
  Surroundings surroundings(0);
  EXPECT_EQ(surroundings.conditions({.now_ns = second, .link_down = true}), ODOM_COND_BUS_DOWN);
  EXPECT_EQ(surroundings.conditions({.now_ns = second, .input_ended = true}),
            ODOM_COND_INPUT_ENDED);
  EXPECT_EQ(surroundings.conditions({.now_ns = second, .carried_over = true}),
            ODOM_COND_CARRIED_OVER);
  EXPECT_EQ(surroundings.conditions({.now_ns = second}), 0U);
}

TEST(Surroundings, ReportARefusalFromStartToEnd) {
  Surroundings surroundings(ODOM_COND_NOT_REALTIME);
  EXPECT_EQ(surroundings.conditions({.now_ns = second}), ODOM_COND_NOT_REALTIME);
  EXPECT_EQ(surroundings.conditions({.now_ns = 3600 * second, .link_down = true}),
            ODOM_COND_NOT_REALTIME | ODOM_COND_BUS_DOWN);
}

TEST(Surroundings, ReportAnIncidentForASecond) {
  Surroundings surroundings(0);
  EXPECT_EQ(surroundings.conditions({.now_ns = second, .frames_lost = 3}), ODOM_COND_FRAMES_LOST);
  EXPECT_EQ(surroundings.conditions({.now_ns = 2 * second - 1, .frames_lost = 3}),
            ODOM_COND_FRAMES_LOST);
  EXPECT_EQ(surroundings.conditions({.now_ns = 2 * second, .frames_lost = 3}), 0U);
  EXPECT_EQ(
      surroundings.conditions({.now_ns = 3 * second, .clock_stepped = true, .frames_lost = 3}),
      ODOM_COND_CLOCK_STEPPED);
  EXPECT_EQ(
      surroundings.conditions({.now_ns = 4 * second - 1, .suspended = true, .frames_lost = 3}),
      ODOM_COND_CLOCK_STEPPED | ODOM_COND_SUSPENDED);
  EXPECT_EQ(surroundings.conditions({.now_ns = 6 * second, .frames_lost = 3}), 0U);
}

TEST(Surroundings, ReportARefusedCameraForAWhile) {
  Surroundings surroundings(0);
  const std::int64_t end_ns = second + Surroundings::refusal_ns;
  EXPECT_EQ(surroundings.conditions({.now_ns = second, .cameras_refused = 2}),
            ODOM_COND_CAMERA_REFUSED);
  EXPECT_EQ(surroundings.conditions({.now_ns = end_ns - 1, .cameras_refused = 2}),
            ODOM_COND_CAMERA_REFUSED);
  EXPECT_EQ(surroundings.conditions({.now_ns = end_ns, .cameras_refused = 2}), 0U);
}

TEST(Surroundings, ReportARestartForAWhile) {
  Surroundings surroundings(0);
  surroundings.restarted(second);
  EXPECT_EQ(surroundings.conditions({.now_ns = second}), ODOM_COND_RESTARTED);
  EXPECT_EQ(surroundings.conditions({.now_ns = second + Surroundings::restart_ns - 1}),
            ODOM_COND_RESTARTED);
  EXPECT_EQ(surroundings.conditions({.now_ns = second + Surroundings::restart_ns}), 0U);
}

}  // namespace
}  // namespace odomd::daemon::surroundings_test
