// Checks of the configuration against its databases.
#include <fstream>

#include "daemon/core/config.hpp"
#include "tests/diagnostics.hpp"
#include "tests/gtest.hpp"
#include "tests/scratch.hpp"

namespace odomd::daemon::config_databases_test {
namespace {

using diagnostics::Named;
using estimator::Source;

constexpr auto database = R"(VERSION ""
BU_: CAR
BO_ 256 WHEEL: 8 CAR
 SG_ RL : 0|16@1- (0.001,0) [0|0] "m/s" CAR
 SG_ RR : 16|16@1- (0.001,0) [0|0] "m/s" CAR
BO_ 257 GYRO: 4 CAR
 SG_ YawRate : 0|16@1- (0.001,0) [0|0] "rad/s" CAR
BO_ 258 STEER: 2 CAR
 SG_ Angle : 0|16@1- (0.0001,0) [0|0] "" CAR
BA_DEF_ BO_ "GenMsgCycleTime" INT 0 65535;
BA_ "GenMsgCycleTime" BO_ 256 10;
)";

class DatabasesTest : public testing::Test {
 protected:
  DatabasesTest() { scratch_.write("car.dbc", database); }

  [[nodiscard]] Config load(const std::string& signals) const {
    std::ofstream(directory_ / "car.toml") << "[can]\ndbc = \"car.dbc\"\n[can.signals]\n"
                                           << signals;
    return load_config(directory_ / "car.toml");
  }

  [[nodiscard]] std::string error_of(const std::string& signals) const {
    Config config = load(signals);
    std::string what =
        message_of([&] { static_cast<void>(load_databases(config, config.warnings)); });
    EXPECT_EQ(what.find('\n'), std::string::npos) << what;
    return what;
  }

  Scratch scratch_;
  std::filesystem::path directory_ = std::filesystem::canonical(scratch_.path(""));
};

constexpr auto wheel =
    "wheel_rear_left = { message = \"WHEEL\", signal = \"RL\", unit = \"m/s\" }\n";
constexpr auto gyro = "yaw_rate = { message = \"GYRO\", signal = \"YawRate\", unit = \"rad/s\" }\n";

TEST_F(DatabasesTest, TimeOutsAreThreeCycleTimesOrATenthOfASecond) {
  Config config = load(std::string(wheel) + gyro +
                       "steering = { message = \"STEER\", signal = \"Angle\", unit = \"rad\", "
                       "timeout = 0.7 }\n");
  diagnostics::Diagnostics warnings;
  EXPECT_EQ(load_databases(config, warnings).size(), 1U);
  const auto timeout = [&](Source source) {
    return config.can.signals[static_cast<std::size_t>(source)].timeout_ns;
  };
  EXPECT_EQ(timeout(Source::wheel_rear_left), 30'000'000);
  EXPECT_EQ(timeout(Source::yaw_rate), 100'000'000);
  EXPECT_EQ(timeout(Source::steering), 700'000'000);
  EXPECT_THAT(warnings, IsEmpty());
}

TEST_F(DatabasesTest, WarnsOfWhatIsOddInMappedMessagesOnly) {
  std::ofstream(directory_ / "car.dbc", std::ios::app)
      << "BO_ 300 ODD: 8 CAR\n SG_ Vin : 0|136@1+ (1,0) [0|0] \"\" CAR\n"
         "CM_ BO_ 77 \"of nothing\";\nVAL_ 256 RR 0 \"on\ntwo lines\" ;\n";
  Config config = load(std::string(wheel) + gyro);
  diagnostics::Diagnostics warnings;
  EXPECT_EQ(load_databases(config, warnings).front().warnings.size(), 3U);
  EXPECT_THAT(warnings, Contains(Named("database_content", "two lines")));
  EXPECT_THAT(warnings, Not(Contains(Named("database_content", "Vin"))));
  EXPECT_THAT(warnings, Not(Contains(Named("database_content", "message 77"))));
  EXPECT_THAT(error_of("motor = { message = \"ODD\", signal = \"Vin\", unit = \"m/s\" }\n"),
              HasSubstr("it was left out in line 13: "));
}

TEST_F(DatabasesTest, WarnsOfRolesThatTheModelWouldLike) {
  Config config = load(wheel);
  diagnostics::Diagnostics warnings;
  config.model = estimator::Model::paper;
  static_cast<void>(load_databases(config, warnings));
  EXPECT_THAT(warnings, Contains(Named("role_not_mapped", "steering")));
  EXPECT_THAT(warnings, Contains(Named("role_not_mapped", "yaw_rate")));

  config.model = estimator::Model::kinematic;
  warnings.clear();
  static_cast<void>(load_databases(config, warnings));
  EXPECT_THAT(warnings, Not(Contains(Named("role_not_mapped", "yaw_rate"))));

  config.model = estimator::Model::full;
  warnings.clear();
  static_cast<void>(load_databases(config, warnings));
  // One speed gives no yaw rate.
  EXPECT_THAT(warnings, Contains(Named("role_not_mapped",
                                       "steering and yaw_rate are not mapped: nothing measures")));
}

TEST_F(DatabasesTest, WarnsOfAServoWithoutACommand) {
  const std::string servo = "[steering]\ndelay = 0.06\n";
  const auto expected = Contains(Named("actuator_without_steering"));
  diagnostics::Diagnostics warnings;
  Config config = load(std::string(wheel) + gyro + servo);
  static_cast<void>(load_databases(config, warnings));
  EXPECT_THAT(warnings, expected);

  config = load(std::string(wheel) + gyro +
                "steering = { message = \"STEER\", signal = \"Angle\", unit = \"rad\" }\n" + servo);
  warnings.clear();
  static_cast<void>(load_databases(config, warnings));
  EXPECT_THAT(warnings, IsEmpty());
}

TEST_F(DatabasesTest, RefusesTheModelInertialWithoutAGyro) {
  const auto file = [](const std::string& signals) {
    return signals + "[filter]\nmodel = \"inertial\"\n";
  };
  EXPECT_THAT(
      error_of(file(wheel)),
      EndsWith("car.toml: [can.signals]: yaw_rate is not mapped, but the model inertial takes its "
               "heading from the gyro only; map yaw_rate, or choose another model, such as full"));
  Config config = load(file(std::string(wheel) + gyro));
  diagnostics::Diagnostics warnings;
  static_cast<void>(load_databases(config, warnings));
  EXPECT_THAT(warnings, IsEmpty());  // the model does not need steering
}

TEST_F(DatabasesTest, RefusesALatencyThatTheWindowOfTheFullModelDoesNotReach) {
  const std::string late =
      "wheel_rear = { message = \"WHEEL\", signal = \"RL\", unit = \"m/s\", latency = 0.3 }\n";
  EXPECT_THAT(error_of(late),
              EndsWith("car.toml: [can.signals] wheel_rear latency: 0.3 s is longer than "
                       "[filter] window, 0.25 s: samples that old would never be fused; "
                       "set window to at least 0.3, or correct the latency"));
  EXPECT_EQ(error_of(late + "[filter]\nwindow = 0.3\n"), "");
  EXPECT_EQ(error_of(late + "[filter]\nmodel = \"kinematic\"\n"), "");
}

TEST_F(DatabasesTest, RefusesACameraThatTheWindowOfTheFullModelDoesNotReach) {
  EXPECT_THAT(error_of(std::string(wheel) + "[camera]\nmax_latency = 0.4\n"),
              EndsWith("car.toml: [camera] max_latency: 0.4 s is longer than [filter] window, "
                       "0.25 s: poses that old would never be fused; set window to at least "
                       "0.4, or lower max_latency"));
  EXPECT_THAT(error_of(std::string(wheel) + "[camera]\nmax_latency = 2\n"),
              EndsWith("would never be fused; lower max_latency"));
  EXPECT_EQ(error_of(std::string(wheel) + "[camera]\nmax_latency = 0.25\n"), "");
}

TEST_F(DatabasesTest, WarnsWhereMoreSamplesComeThanTheWindowHolds) {
  std::string many = database;
  many.replace(many.rfind(" 10;"), 4, " 1; ");
  std::ofstream(directory_ / "car.dbc") << many;
  const std::string both = std::string(wheel) +
                           "wheel_rear_right = { message = \"WHEEL\", signal = \"RR\", unit = "
                           "\"m/s\" }\n[filter]\nwindow = ";
  diagnostics::Diagnostics warnings;
  Config config = load(both + "1.0\n");
  static_cast<void>(load_databases(config, warnings));
  EXPECT_THAT(warnings, Contains(Named("window_overflows", "3010 samples come in 1.5 s")));
  warnings.clear();
  config = load(both + "0.3\n");
  static_cast<void>(load_databases(config, warnings));
  EXPECT_THAT(warnings, Not(Contains(Named("window_overflows"))));
}

TEST_F(DatabasesTest, TurnsBothAxesOfAnAccelerometerOrNone) {
  std::ofstream(directory_ / "car.dbc", std::ios::app)
      << "BO_ 259 IMU: 4 CAR\n SG_ AX : 0|16@1- (0.001,0) [0|0] \"m/s2\" CAR\n"
         " SG_ AY : 16|16@1- (0.001,0) [0|0] \"m/s2\" CAR\n"
         "BO_ 260 OTHER: 2 CAR\n SG_ AY : 0|16@1- (0.001,0) [0|0] \"m/s2\" CAR\n";
  const auto axis = [](const std::string& role, const std::string& message,
                       const std::string& signal, const std::string& more = "") {
    return role + " = { message = \"" + message + "\", signal = \"" + signal +
           "\", unit = \"m/s2\"" + more + " }\n";
  };
  const std::string along = wheel + axis("accel_x", "IMU", "AX");
  const std::string turned = "[imu]\nyaw = 1.57\n";
  EXPECT_EQ(error_of(along + axis("accel_y", "IMU", "AY") + turned), "");
  EXPECT_EQ(error_of(wheel + turned), "");
  EXPECT_THAT(error_of(along + turned),
              HasSubstr("[imu] yaw: accel_x and accel_y are rotated together: map accel_y too"));
  EXPECT_THAT(error_of(along + axis("accel_y", "OTHER", "AY") + turned),
              HasSubstr("take both from one message"));
  EXPECT_THAT(error_of(along + axis("accel_y", "IMU", "AY", ", latency = 0.01") + turned),
              HasSubstr("give both the same latency"));
}

TEST_F(DatabasesTest, RefusesACarWithoutAnySpeed) {
  EXPECT_THAT(error_of(gyro), HasSubstr("car.toml: [can.signals]: no speed is mapped"));
}

TEST_F(DatabasesTest, SuggestsTheNearestMessageAndSignal) {
  EXPECT_THAT(
      error_of("wheel_rear = { message = \"WHEELS\", signal = \"RL\", unit = \"m/s\" }\n"),
      AllOf(HasSubstr("car.toml: "), HasSubstr("wheel_rear"), HasSubstr("the nearest is 'WHEEL'")));
  EXPECT_THAT(error_of("wheel_rear = { message = \"WHEEL\", signal = \"RX\", unit = \"m/s\" }\n"),
              AllOf(HasSubstr("wheel_rear"), HasSubstr("the nearest is 'RL'")));
}

TEST_F(DatabasesTest, RefusesAUnitThatContradictsTheDatabase) {
  EXPECT_THAT(error_of("wheel_rear = { message = \"WHEEL\", signal = \"RL\", unit = \"km/h\" }\n"),
              AllOf(HasSubstr("wheel_rear"), HasSubstr("km/h"), HasSubstr("m/s")));
}

TEST_F(DatabasesTest, RefusesADatabaseThatIsNotThere) {
  std::filesystem::remove(directory_ / "car.dbc");
  EXPECT_THAT(error_of(wheel), AllOf(HasSubstr("car.dbc: cannot be read"),
                                     HasSubstr("(a database for "), HasSubstr("car.toml)")));
}

TEST_F(DatabasesTest, NumbersTheBusesThatBindingsName) {
  const Config config = load(
      "wheel_rear_left = { message = \"WHEEL\", signal = \"RL\", unit = \"m/s\", bus = \"can1\" }\n"
      "wheel_rear_right = { message = \"WHEEL\", signal = \"RR\", unit = \"m/s\", bus = \"can0\" "
      "}\n"
      "yaw_rate = { message = \"GYRO\", signal = \"YawRate\", unit = \"rad/s\", bus = \"can1\" "
      "}\n");
  EXPECT_THAT(expected_buses(config), ElementsAre("can1", "can0"));
}

TEST_F(DatabasesTest, RefusesABusThatNobodyListensTo) {
  Config config = load(
      "wheel_rear = { message = \"WHEEL\", signal = \"RL\", unit = \"m/s\", bus = \"can1\" }\n");
  diagnostics::Diagnostics warnings;
  config.can.sources = {"can0", "can1"};
  EXPECT_NO_THROW(static_cast<void>(load_databases(config, warnings)));
  config.can.sources = {"can0", "drive.log"};  // the log may have this bus
  EXPECT_NO_THROW(static_cast<void>(load_databases(config, warnings)));
  config.can.sources = {"can0", "can2"};
  EXPECT_THAT(message_of([&] { static_cast<void>(load_databases(config, warnings)); }),
              HasSubstr("signal 'wheel_rear': bus 'can1' is not a source; the nearest is 'can0'"));
}

}  // namespace
}  // namespace odomd::daemon::config_databases_test
