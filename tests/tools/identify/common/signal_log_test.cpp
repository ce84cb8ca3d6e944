#include "tools/identify/common/signal_log.hpp"
#include "tests/diagnostics.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "tests/tools/scratch.hpp"

namespace odomd::tools::signal_log_test {
namespace {

using estimator::Source;
using testing::AllOf;
using testing::ElementsAre;
using testing::HasSubstr;
using testing::Not;

constexpr std::string_view dbc = R"(VERSION ""
BO_ 257 WHEEL: 2 Car
 SG_ Speed : 0|16@1- (0.001,0) [0|0] "m/s" X
BO_ 258 IMU: 4 Car
 SG_ AccX : 0|16@1- (0.001,0) [0|0] "m/s2" X
 SG_ AccY : 16|16@1- (0.001,0) [0|0] "m/s2" X
)";

constexpr std::string_view car = R"([can]
source = "drive.log"
dbc = "car.dbc"
[can.signals]
wheel_rear = { message = "WHEEL", signal = "Speed", unit = "m/s", latency = 0.01, scale = 2.0 }
accel_x = { message = "IMU", signal = "AccX", unit = "m/s2" }
accel_y = { message = "IMU", signal = "AccY", unit = "m/s2" }
[imu]
yaw = 1.5707963267948966
)";

SignalLog read(const Scratch& scratch, const std::string& log) {
  scratch.write("car.dbc", std::string{dbc});
  const auto config = daemon::load_config(scratch.write("car.toml", std::string{car}));
  const std::vector<std::string> logs{scratch.write("drive.log", log)};
  return read_signals(config, logs);
}

TEST(SignalLog, HoldsEachSignalInSiAtTheTimeItWasTaken) {
  const Scratch scratch;
  const SignalLog log = read(scratch,
                             "(100.000000) can0 101#E803\n"
                             "(100.005000) can0 102#D0070000\n"
                             "(100.020000) can0 101#18FC\n");
  EXPECT_THAT(log.of(Source::wheel_rear).t_ns, ElementsAre(99'990'000'000, 100'010'000'000));
  EXPECT_THAT(log.of(Source::wheel_rear).value, ElementsAre(2.0, -2.0));
  // A quarter turn of the sensor: what it calls x is the car's y.
  EXPECT_THAT(log.of(Source::accel_x).value, ElementsAre(testing::DoubleNear(0.0, 1e-12)));
  EXPECT_THAT(log.of(Source::accel_y).value, ElementsAre(2.0));
  EXPECT_TRUE(log.of(Source::yaw_rate).empty());
  EXPECT_EQ(log.first_ns, 100'000'000'000);
  EXPECT_EQ(log.last_ns, 100'020'000'000);
  EXPECT_THAT(log.warnings,
              testing::Not(testing::Contains(diagnostics::Named("log_content", "left out"))));
}

TEST(SignalLog, LeavesOutSamplesWithoutATimeOfTheirOwnAndSaysHowMany) {
  const Scratch scratch;
  const SignalLog log = read(scratch,
                             "(100.000000) can0 101#E803\n"
                             "(100.000000) can0 101#E903\n"
                             "(100.010000) can0 101#EA03\n");
  EXPECT_THAT(log.of(Source::wheel_rear).value, ElementsAre(2.0, 2.004));
  EXPECT_THAT(log.warnings, testing::Contains(diagnostics::Named(
                                "log_content", "1 sample without a time of its own")));
}

TEST(SignalLog, ALogWhoseTimesRunBackwardsIsToBeSorted) {
  const Scratch scratch;
  const auto refused = [&](const std::string& log) {
    return message_of([&] { (void)read(scratch, log); });
  };
  EXPECT_THAT(refused("(100.000000) can0 101#E803\n(101.000000) can0 101#E903\n"
                      "(90.000000) can0 101#E803\n(91.000000) can0 101#E903\n"),
              AllOf(HasSubstr("drive.log:3: from here on 2 frames have stamps a second or more "
                              "earlier than frames before them; sort the log"),
                    Not(HasSubstr("\n"))));
  EXPECT_THAT(refused("(100.000000) can0 101#E803\n(99.000000) can0 102#D0070000\n"),
              HasSubstr("drive.log:2: this frame has a stamp"));
  // Buses whose drivers deliver at their own pace, and a frame without a stamp.
  EXPECT_EQ(
      refused(
          "(100.000000) can0 101#E803\n(99.100000) can0 102#D0070000\n(0.000000) can0 101#E903\n"),
      "");
}

TEST(SignalLog, SaysWhichMessageOfANeededSignalIsMissing) {
  const Scratch scratch;
  const SignalLog log = read(scratch, "(100.000000) can0 101#E803\n(100.100000) can0 101#E903\n");
  const auto refused = [&](Source source) { return message_of([&] { (void)log.need(source); }); };
  EXPECT_THAT(refused(Source::accel_y),
              HasSubstr("drive.log: has no accel_y: message 'IMU' (accel_x, accel_y): no "
                        "frame of it is in the log"));
  EXPECT_THAT(refused(Source::yaw_rate), HasSubstr("map it in [can.signals]"));
  EXPECT_EQ(refused(Source::wheel_rear), "");
}

TEST(SignalLog, ALogThatIsNoLogIsRefused) {
  const Scratch scratch;
  EXPECT_THROW((void)read(scratch, "hello\n"), std::invalid_argument);
}

}  // namespace
}  // namespace odomd::tools::signal_log_test
