// The output of `odomd --check`.
#include "daemon/check.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace odomd::daemon::check_test {
namespace {

using estimator::Source;
using testing::HasSubstr;
using testing::Not;

Config with_signal(std::int64_t timeout_ns, std::int64_t latency_ns) {
  Config config;
  can::SignalBinding binding;
  binding.channel = static_cast<std::uint16_t>(Source::wheel_rear);
  binding.role = "wheel_rear";
  binding.message = "WHEEL";
  binding.signals = {"REAR"};
  binding.unit = can::Unit::m_per_s;
  binding.latency_ns = latency_ns;
  config.can.bindings.push_back(binding);
  config.can.signals[binding.channel] = {true, 0.05, timeout_ns};
  return config;
}

TEST(CheckSummary, ShowsTimesAsTheyWereWritten) {
  const auto text = summary(with_signal(15'000'000, 7'000'000), {}, {});
  EXPECT_THAT(text,
              HasSubstr("WHEEL.REAR in m/s, sigma 0.05, time-out 0.015 s, latency 0.007 s\n"));
  EXPECT_THAT(text, HasSubstr("every 0.005 s\n"));
}

TEST(CheckSummary, RoundsTimesToSixDigits) {
  const auto text = summary(with_signal(333'333'333, 0), {}, {});
  EXPECT_THAT(text, HasSubstr("time-out 0.333333 s\n"));
  EXPECT_THAT(text, Not(HasSubstr("old")));
}

TEST(CheckSummary, ShowsTheKindOfEachSource) {
  Config config = with_signal(30'000'000, 0);
  EXPECT_THAT(summary(config, {}, {}), HasSubstr("none: give --can or [can] source"));
  config.can.sources = {"can0", "-"};
  EXPECT_THAT(summary(config, {}, {}),
              testing::AllOf(HasSubstr("can0 (interface)\n"), HasSubstr("standard input\n")));
}

TEST(CheckSummary, ShowsWhoMayReachWhat) {
  Config config = with_signal(30'000'000, 0);
  config.shm.mode = 0640;
  config.shm.group = "odom";
  config.status.socket = "/run/odomd/status.sock";
  const auto text = summary(config, {}, {});
  EXPECT_THAT(text, HasSubstr("/odomd (mode 0640, group odom)\n"));
  EXPECT_THAT(text, HasSubstr("/run/odomd/status.sock (mode 0666)\n"));
}

TEST(CheckSummary, ShowsServoGripAndLeanWhereTheyAreGiven) {
  Config config = with_signal(30'000'000, 0);
  const auto plain = summary(config, {}, {});
  for (const char* const line : {"  grip ", "  steering ", "  lean "})
    EXPECT_THAT(plain, Not(HasSubstr(line)));
  config.vehicle.grip_rear = 9.5;
  config.vehicle.steering = {.delay_s = 0.06, .lag_s = 0.1, .rate_limit = 3.0};
  config.roll_gradient = 0.12;
  const auto text = summary(config, {}, {});
  EXPECT_THAT(text, HasSubstr("front without limit, rear at most 9.5 m/s2\n"));
  EXPECT_THAT(text, HasSubstr("a command: 0.06 s delay, 0.1 s lag, rate at most 3 rad/s\n"));
  EXPECT_THAT(text, HasSubstr("roll 0.12 rad per g, pitch learnt\n"));
}

TEST(CheckSummary, EndsWithTheWarnings) {
  const diagnostics::Diagnostics warnings{
      found(diagnostics::kind("role_not_mapped"), "car.toml", "steering is not mapped")};
  EXPECT_THAT(summary(with_signal(30'000'000, 0), {}, warnings),
              testing::EndsWith("warnings\n  " + text_of(warnings.front()) + "\n"));
}

}  // namespace
}  // namespace odomd::daemon::check_test
