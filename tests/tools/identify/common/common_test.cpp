// What the methods of odom identify share.
#include "tests/diagnostics.hpp"
#include "tests/tools/scratch.hpp"
#include "tools/config_patch/config_patch.hpp"
#include "tools/identify/common/finding.hpp"
#include "tools/identify/common/signal_log.hpp"

namespace odomd::tools::common_test {
namespace {

using estimator::Source;

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

TEST(SignalLog, HasEachSignalInSiUnitsAtItsSampleTime) {
  const Scratch scratch;
  const SignalLog log = read(scratch,
                             "(100.000000) can0 101#E803\n"
                             "(100.005000) can0 102#D0070000\n"
                             "(100.020000) can0 101#18FC\n");
  EXPECT_THAT(log.of(Source::wheel_rear).t_ns, ElementsAre(99'990'000'000, 100'010'000'000));
  EXPECT_THAT(log.of(Source::wheel_rear).value, ElementsAre(2.0, -2.0));
  // The sensor is rotated by a quarter turn: its x is the car's y.
  EXPECT_THAT(log.of(Source::accel_x).value, ElementsAre(testing::DoubleNear(0.0, 1e-12)));
  EXPECT_THAT(log.of(Source::accel_y).value, ElementsAre(2.0));
  EXPECT_TRUE(log.of(Source::yaw_rate).empty());
  EXPECT_EQ(log.first_ns, 100'000'000'000);
  EXPECT_EQ(log.last_ns, 100'020'000'000);
  EXPECT_THAT(log.warnings,
              testing::Not(testing::Contains(diagnostics::Named("log_content", "left out"))));
}

TEST(SignalLog, CountsSamplesWithoutATimeOfTheirOwn) {
  const Scratch scratch;
  const SignalLog log = read(scratch,
                             "(100.000000) can0 101#E803\n"
                             "(100.000000) can0 101#E903\n"
                             "(100.010000) can0 101#EA03\n");
  EXPECT_THAT(log.of(Source::wheel_rear).value, ElementsAre(2.0, 2.004));
  EXPECT_THAT(log.warnings, testing::Contains(diagnostics::Named(
                                "log_content", "1 sample without a time of its own")));
}

TEST(SignalLog, RefusesALogWhoseTimesRunBackwards) {
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
  // Accepted: two buses whose drivers deliver at different times, and a frame without a stamp.
  EXPECT_EQ(
      refused(
          "(100.000000) can0 101#E803\n(99.100000) can0 102#D0070000\n(0.000000) can0 101#E903\n"),
      "");
}

TEST(SignalLog, NamesTheMissingMessageOfANeededSignal) {
  const Scratch scratch;
  const SignalLog log = read(scratch, "(100.000000) can0 101#E803\n(100.100000) can0 101#E903\n");
  const auto refused = [&](Source source) { return message_of([&] { (void)log.need(source); }); };
  EXPECT_THAT(refused(Source::accel_y),
              HasSubstr("drive.log: has no accel_y: message 'IMU' (accel_x, accel_y): no "
                        "frame of it is in the log"));
  EXPECT_THAT(refused(Source::yaw_rate), HasSubstr("map it in [can.signals]"));
  EXPECT_EQ(refused(Source::wheel_rear), "");
}

// Values written to a configuration, and values kept there.

constexpr auto identified_car = R"([vehicle]
mass = 3.0            # kg (odom identify mass: +- 0.004 kg, scale)
front_axle = 0.175    # m, by hand
rear_axle = 0.085     # m (odom identify fit: +1.0 %)
yaw_inertia = 0.028   # (odom identify inertia: +- 0.0001 kg m2, bifilar pendulum)
cornering_stiffness_front = 20.0
cornering_stiffness_rear = 60.0
track_width = 0.16
[can]
source = "can0"
dbc = "a.dbc"
[can.signals]
wheel_rear = { message = "W", signal = "S", unit = "m/s" }
yaw_rate = { message = "G", signal = "R", unit = "rad/s", sigma = 0.002 } # (sigma: odom identify noise: +- 0.00002 rad/s, standing)
)";

Finding finding(const std::string& key, double value, double sigma) {
  return {.name = key, .key = key, .value = value, .sigma = sigma};
}

Findings findings(const std::string& method, const std::string& origin,
                  std::vector<Finding> values) {
  return {.method = method, .origin = origin, .values = std::move(values)};
}

class DeliveryTest : public testing::Test {
 protected:
  /// Returns standard error.
  std::string deliver_to_car(const Findings& findings, bool force = false) {
    testing::internal::CaptureStdout();
    testing::internal::CaptureStderr();
    EXPECT_NO_THROW(deliver(findings, {.json = false, .write = car_, .force = force}));
    output_ = testing::internal::GetCapturedStdout();
    return testing::internal::GetCapturedStderr();
  }
  [[nodiscard]] double now(const std::string& key) const { return value_in(car_, key)->value; }

  const Scratch scratch_;
  const std::string car_ = scratch_.write("car.toml", identified_car).string();
  std::string output_;
};

TEST_F(DeliveryTest, KeepsMorePreciseValuesAndWritesTheRest) {
  const Findings fit =
      findings("fit", "60 s of drive",
               {finding("vehicle.mass", 3.02, 0.01), finding("vehicle.front_axle", 0.17, 0.002),
                finding("vehicle.rear_axle", 0.08, 0.002)});
  EXPECT_THAT(deliver_to_car(fit),
              AllOf(HasSubstr("vehicle.mass stays 3 (odom identify mass: +- 0.004 kg, scale), "
                              "which is more precise than 3.02 +- 0.02; --force replaces it"),
                    HasSubstr("2 keys written to " + car_ +
                              ": vehicle.front_axle, vehicle.rear_axle; 1 kept")));
  EXPECT_THAT(output_, HasSubstr("kept: the previous value is more precise (+- 0.004)"));
  EXPECT_EQ(now("vehicle.mass"), 3.0);
  EXPECT_EQ(now("vehicle.front_axle"), 0.17) << "nothing says how precise it was";
  EXPECT_EQ(now("vehicle.rear_axle"), 0.08);

  EXPECT_THAT(deliver_to_car(fit, true), AllOf(HasSubstr("3 keys"), Not(HasSubstr("kept"))));
  EXPECT_EQ(now("vehicle.mass"), 3.02);
}

TEST_F(DeliveryTest, ReplacesValuesOfTheSamePrecision) {
  const auto weighed = [](double sigma) {
    return findings("mass", "scale", {finding("vehicle.mass", 3.1, sigma)});
  };
  EXPECT_THAT(deliver_to_car(weighed(0.0027)), HasSubstr("its values are more precise"));
  EXPECT_EQ(now("vehicle.mass"), 3.0);
  EXPECT_THAT(deliver_to_car(weighed(0.0025)), HasSubstr("1 key written"));
  EXPECT_EQ(now("vehicle.mass"), 3.1);
}

// The stiffness of one curve with the grip of another does not describe a tyre.
TEST_F(DeliveryTest, ReplacesAGroupOfValuesAsAWhole) {
  const auto measured = [](double sigma_of_grip) {
    return findings("fit", "60 s of drive",
                    {finding("vehicle.cornering_stiffness_front", 21.0, 1.0),
                     finding("vehicle.grip_front", 9.0, sigma_of_grip)});
  };
  Findings precise = measured(0.1);
  precise.values[0].value = 20.5;
  precise.values[0].sigma = 0.1;
  EXPECT_THAT(deliver_to_car(precise), HasSubstr("2 keys written"));
  EXPECT_THAT(deliver_to_car(measured(0.1)), HasSubstr("2 keys written"));
  EXPECT_EQ(now("vehicle.cornering_stiffness_front"), 21.0) << "its grip is as precise as before";
  EXPECT_THAT(deliver_to_car(precise), HasSubstr("2 keys written"));
  EXPECT_THAT(deliver_to_car(measured(1.0)), HasSubstr("its values are more precise"));
  EXPECT_EQ(now("vehicle.cornering_stiffness_front"), 20.5);
}

TEST_F(DeliveryTest, WarnsOfContradictions) {
  const auto weighed = [](double value, double sigma) {
    return findings("mass", "scale", {finding("vehicle.mass", value, sigma)});
  };
  EXPECT_THAT(deliver_to_car(weighed(3.01, 0.02)),
              AllOf(HasSubstr("nothing written to " + car_), Not(HasSubstr("contradict"))));
  EXPECT_THAT(deliver_to_car(weighed(3.5, 0.02)),
              AllOf(HasSubstr("they contradict each other"), HasSubstr("measure again")));
  EXPECT_THAT(deliver_to_car(weighed(2985.0, 1.0)),
              AllOf(HasSubstr("vehicle.mass stays 3 "), HasSubstr("[W502]")));
  EXPECT_EQ(contents(car_), identified_car);
  EXPECT_THAT(deliver_to_car(weighed(2985.0, 1.0), true),
              AllOf(HasSubstr("vehicle.mass was 3 and becomes 2985"), HasSubstr("[W501]")));
}

TEST_F(DeliveryTest, ShowsKeptValuesInJson) {
  const Findings fit = findings("fit", "60 s of drive", {finding("vehicle.mass", 3.02, 0.01)});
  testing::internal::CaptureStdout();
  testing::internal::CaptureStderr();
  deliver(fit, {.json = true, .write = car_, .force = false});
  static_cast<void>(testing::internal::GetCapturedStderr());
  EXPECT_THAT(testing::internal::GetCapturedStdout(),
              AllOf(HasSubstr("\"code\":\"W502\""), HasSubstr("\"left_as_configured\":true"),
                    HasSubstr("kept: the previous value is more precise (+- 0.00")));
}

TEST_F(DeliveryTest, ReplacesAnotherQuantityHoweverPrecise) {
  const auto turned = [](const std::string& method) {
    return findings(method, "", {finding("vehicle.yaw_inertia", 0.03, 0.001)});
  };
  EXPECT_THAT(deliver_to_car(turned("inertia")), HasSubstr("vehicle.yaw_inertia stays 0.028"));
  EXPECT_THAT(deliver_to_car(turned("fit")),
              AllOf(HasSubstr("1 key written"), Not(HasSubstr("stays"))));
  EXPECT_EQ(now("vehicle.yaw_inertia"), 0.03);
}

}  // namespace
}  // namespace odomd::tools::common_test
