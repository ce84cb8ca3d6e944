// Checks of the configuration's numbers, and of the configuration against its databases.
#include <functional>

#include "config_files.hpp"
#include "daemon/core/config_sections.hpp"
#include "tests/table.hpp"

namespace odomd::daemon::config_databases_test {
namespace {

using diagnostics::Named;
using estimator::Source;

const std::string database = R"(VERSION ""
BU_: CAR
BO_ 256 WHEEL: 8 CAR
 SG_ RL : 0|16@1- (0.001,0) [0|0] "m/s" CAR
 SG_ RR : 16|16@1- (0.001,0) [0|0] "m/s" CAR
BO_ 257 GYRO: 4 CAR
 SG_ YawRate : 0|16@1- (0.001,0) [0|0] "rad/s" CAR
BO_ 258 STEER: 2 CAR
 SG_ Angle : 0|16@1- (0.0001,0) [0|0] "" CAR
BO_ 259 IMU: 4 CAR
 SG_ AX : 0|16@1- (0.001,0) [0|0] "m/s2" CAR
 SG_ AY : 16|16@1- (0.001,0) [0|0] "m/s2" CAR
BO_ 260 OTHER: 2 CAR
 SG_ AY : 0|16@1- (0.001,0) [0|0] "m/s2" CAR
BA_DEF_ BO_ "GenMsgCycleTime" INT 0 65535;
BA_ "GenMsgCycleTime" BO_ 256 10;
)";

const std::string head = "[can]\ndbc = 'car.dbc'\n[can.signals]\n";
const std::string wheel = "wheel_rear_left = { message = 'WHEEL', signal = 'RL', unit = 'm/s' }\n";
const std::string other = "wheel_rear_right = { message = 'WHEEL', signal = 'RR', unit = 'm/s' }\n";
const std::string gyro = "yaw_rate = { message = 'GYRO', signal = 'YawRate', unit = 'rad/s' }\n";
const std::string steering =
    "steering = { message = 'STEER', signal = 'Angle', unit = 'rad', timeout = 0.7 }\n";

class DatabasesTest : public ConfigTest {
 protected:
  DatabasesTest() { scratch_.write("car.dbc", database); }

  /// The warnings other than the one about the reference car.
  [[nodiscard]] diagnostics::Diagnostics further_warnings_of(const std::string& signals) const {
    auto warnings = warnings_of(head + signals);
    EXPECT_THAT(warnings.front(), Named("reference_car"));
    warnings.erase(warnings.begin());
    return warnings;
  }
};

TEST_F(DatabasesTest, TimeoutsDefaultToThreeCycleTimesOr100Ms) {
  Config config = load(head + wheel + gyro + steering);
  diagnostics::Diagnostics warnings;
  EXPECT_EQ(load_databases(config, warnings).size(), 1U);
  EXPECT_THAT(warnings, IsEmpty());
  const auto timeout = [&](Source source) {
    return config.can.signals[estimator::index_of(source)].timeout_ns;
  };
  EXPECT_EQ(timeout(Source::wheel_rear_left), 30'000'000);
  EXPECT_EQ(timeout(Source::yaw_rate), 100'000'000);
  EXPECT_EQ(timeout(Source::steering), 700'000'000);
}

TEST_F(DatabasesTest, WarnsAboutMappedMessagesOnly) {
  scratch_.write("car.dbc", database +
                                "BO_ 300 ODD: 8 CAR\n"
                                " SG_ Vin : 0|136@1+ (1,0) [0|0] \"\" CAR\n"
                                "CM_ BO_ 77 \"of nothing\";\nVAL_ 256 RR 0 \"on\ntwo lines\" ;\n");
  Config config = load(head + wheel + gyro);
  diagnostics::Diagnostics warnings;
  EXPECT_EQ(load_databases(config, warnings).front().warnings.size(), 3U);
  EXPECT_THAT(warnings, ElementsAre(Named("role_not_mapped", "steering is"),
                                    Named("database_content", "two lines")));
  EXPECT_THAT(error_of(head + "motor = { message = 'ODD', signal = 'Vin', unit = 'm/s' }\n"),
              HasSubstr("it was left out in line 18: "));
}

TEST_F(DatabasesTest, WarnsAboutUnmappedRolesOfTheModel) {
  const auto not_mapped = [&](const std::string& roles) { return Named("role_not_mapped", roles); };
  const auto model = [](const std::string& name) { return "[filter]\nmodel = '" + name + "'\n"; };
  EXPECT_THAT(further_warnings_of(wheel + model("paper")),
              ElementsAre(not_mapped("steering is"), not_mapped("yaw_rate is")));
  EXPECT_THAT(further_warnings_of(wheel + model("kinematic")),
              ElementsAre(not_mapped("steering is")));
  EXPECT_THAT(further_warnings_of(gyro + wheel + model("inertial")), IsEmpty());
  // One speed gives no yaw rate.
  EXPECT_THAT(further_warnings_of(wheel),
              ElementsAre(not_mapped("steering and yaw_rate are not mapped: nothing measures")));
  EXPECT_THAT(further_warnings_of(wheel + other),
              ElementsAre(not_mapped("only the wheels measure how the car turns")));
}

TEST_F(DatabasesTest, WarnsAboutAnActuatorWithoutSteering) {
  const std::string servo = "[steering]\ndelay = 0.06\n";
  EXPECT_THAT(further_warnings_of(wheel + gyro + servo),
              ElementsAre(Named("role_not_mapped"), Named("actuator_without_steering")));
  EXPECT_THAT(further_warnings_of(wheel + gyro + steering + servo), IsEmpty());
}

TEST_F(DatabasesTest, WarnsIfTheWindowCannotHoldAllSamples) {
  std::string many = database;
  scratch_.write("car.dbc", many.replace(many.rfind(" 10;"), 4, " 1;"));
  const std::string both = wheel + other + gyro + steering + "[filter]\nwindow = ";
  EXPECT_THAT(further_warnings_of(both + "1.0\n"),
              ElementsAre(Named("window_overflows", "3010 samples come in 1.5 s")));
  EXPECT_THAT(further_warnings_of(both + "0.3\n"), IsEmpty());
}

TEST_F(DatabasesTest, ErrorsNameTheKeyAndTheFix) {
  for_each_row(R"(
[filter]¶model = 'inertial' -> [can.signals]: yaw_rate is not mapped, but the model inertial takes
  its heading from the gyro only; map yaw_rate, or choose another model, such as full
motor = { message = 'WHEEL', signal = 'RR', unit = 'm/s', latency = 0.3 } -> [can.signals] motor
  latency: 0.3 s is longer than [filter] window, 0.25 s: samples that old would never be fused; set
  window to at least 0.3, or correct the latency
[camera]¶max_latency = 0.4 -> [camera] max_latency: 0.4 s is longer than [filter] window, 0.25 s:
  poses that old would never be fused; set window to at least 0.4, or lower max_latency
[camera]¶max_latency = 2 -> [camera] max_latency: 2 s is longer than [filter] window, 0.25 s: poses
  that old would never be fused; lower max_latency
motor = { message = 'WHEELS', signal = 'RL', unit = 'm/s' } -> signal 'motor': no message 'WHEELS' in
  car.dbc; the nearest is 'WHEEL'
)",
               [&](const std::string& mistake, const std::string& error) {
                 EXPECT_EQ(error_of(head + wheel + mistake + "\n"), "car.toml: " + error);
               });
  EXPECT_EQ(
      error_of(head + gyro),
      "car.toml: [can.signals]: no speed is mapped; map wheel_rear, the four wheels or motor");
}

TEST_F(DatabasesTest, AcceptsALatencyThatFitsTheWindowOrIsIgnored) {
  const std::string late =
      wheel + "motor = { message = 'WHEEL', signal = 'RR', unit = 'm/s', latency = 0.3 }\n";
  EXPECT_EQ(error_of(head + late + "[filter]\nwindow = 0.3\n"), "");
  EXPECT_EQ(error_of(head + late + "[filter]\nmodel = 'kinematic'\n"), "");
  EXPECT_EQ(error_of(head + wheel + "[camera]\nmax_latency = 0.25\n"), "");
}

TEST_F(DatabasesTest, RotatesBothAxesOfAnAccelerometerOrNone) {
  const auto error = [&](const std::string& along, const std::string& across) {
    std::string text = head + wheel;
    if (!along.empty()) text += "accel_x = { unit = 'm/s2', " + along + " }\n";
    if (!across.empty()) text += "accel_y = { unit = 'm/s2', " + across + " }\n";
    return error_of(text + "[imu]\nyaw = 1.57\n");
  };
  const std::string x = "message = 'IMU', signal = 'AX'", y = "message = 'IMU', signal = 'AY'";
  const std::string begin = "car.toml: [imu] yaw: accel_x and accel_y are rotated together: ";
  EXPECT_EQ(error(x, y), "");
  EXPECT_EQ(error("", ""), "");
  EXPECT_EQ(error(x, ""), begin + "map accel_y too, or leave yaw out");
  EXPECT_EQ(error("", y), begin + "map accel_x too, or leave yaw out");
  EXPECT_EQ(error(x, "message = 'OTHER', signal = 'AY'"),
            begin + "take both from one message on one bus, or leave yaw out");
  EXPECT_EQ(error(x, y + ", latency = 0.01"), begin + "give both the same latency");
}

TEST_F(DatabasesTest, RefusesAMissingDatabase) {
  std::filesystem::remove(directory_ / "car.dbc");
  EXPECT_THAT(error_of(head + wheel),
              AllOf(StartsWith("car.dbc: cannot be read"), EndsWith("(a database for car.toml)")));
}

TEST_F(DatabasesTest, NumbersNamedBusesAndRefusesUnknownOnes) {
  Config config = load(head + R"(
wheel_rear_left = { message = "WHEEL", signal = "RL", unit = "m/s", bus = "can1" }
wheel_rear_right = { message = "WHEEL", signal = "RR", unit = "m/s", bus = "can0" }
yaw_rate = { message = "GYRO", signal = "YawRate", unit = "rad/s", bus = "can1" }
)");
  EXPECT_THAT(expected_buses(config), ElementsAre("can1", "can0"));
  const auto error = [&](const std::vector<std::string>& sources) {
    config.can.sources = sources;
    return message_of([&] { static_cast<void>(load_databases(config, config.warnings)); });
  };
  EXPECT_EQ(error({"can0", "can1"}), "");
  EXPECT_EQ(error({"can0", "drive.log"}), "") << "the log may have this bus";
  EXPECT_THAT(error({"can0", "can2"}),
              EndsWith(": signal 'wheel_rear_left': bus 'can1' is not a source; the nearest is "
                       "'can0'"));
}

diagnostics::Diagnostics size_warnings_of(const std::function<void(Config&)>& change) {
  Config config;
  config.file = "car.toml";
  change(config);
  diagnostics::Diagnostics warnings;
  check_sizes(config, warnings);
  return warnings;
}

TEST(ConfigChecks, AcceptCarsOfAnySize) {
  EXPECT_THAT(size_warnings_of([](Config&) {}), IsEmpty());  // the reference car
  const estimator::Vehicle cars[] = {
      {1.58, 0.0805, 0.093, 0.0048, 17.4, 21.9, 0.12},                 // 1:10 with a light body
      {1500.0, 1.2, 1.5, 2500.0, 80'000, 100'000, 1.6},                // a saloon
      {230.0, 0.8, 0.75, 110.0, 12'000, 14'000, 1.2},                  // formula student
      {18'000.0, 2.5, 3.5, 120'000, 300'000, 700'000, 2.1, 9.0, 9.0},  // a lorry
  };
  for (const estimator::Vehicle& car : cars)
    EXPECT_THAT(size_warnings_of([&](Config& config) { config.vehicle = car; }), IsEmpty())
        << car.mass;
}

TEST(ConfigChecks, WarnAboutNumbersInAnotherUnit) {
  struct Case {
    const char *warning, *text;
    void (*change)(Config&);
  };
  const Case cases[]{
      {"inertia_unlike_a_car", "car.toml: [vehicle]: yaw_inertia 283 is 6.4e+03 times",
       [](Config& c) { c.vehicle.yaw_inertia = 283.0; }},
      {"track_unlike_a_car", "track_width 160 m", [](Config& c) { c.vehicle.track_width = 160.0; }},
      {"stiffness_unlike_a_tyre", "cornering_stiffness_rear 0.6 is 0.02 times",
       [](Config& c) { c.vehicle.cornering_stiffness_rear = 0.6; }},
      {"grip_unlike_a_tyre", "grip_front 9500", [](Config& c) { c.vehicle.grip_front = 9500.0; }},
      {"grip_unlike_a_tyre", "grip_rear 0.1", [](Config& c) { c.vehicle.grip_rear = 0.1; }},
      {"sensor_outside_car", "car.toml: [camera] lever_arm: [50, 0] is 1.9e+02 wheelbases",
       [](Config& c) { c.camera.lever_arm[0] = 50.0; }},
      {"sensor_outside_car", "car.toml: [reference] lever_arm: [0, -50]",
       [](Config& c) { c.reference_lever_arm.emplace()[1] = -50.0; }},
      {"sensor_outside_car", "[imu] position", [](Config& c) { c.imu_position[1] = -12.0; }}};
  for (const auto& [warning, text, change] : cases)
    EXPECT_THAT(size_warnings_of(change), ElementsAre(Named(warning, text)));
  const auto grams = size_warnings_of([](Config& c) { c.vehicle.mass = 2985.0; });
  EXPECT_THAT(grams, Contains(Named("mass_unlike_a_car", "2985 kg on a wheelbase of 0.26 m")));
  const auto millimetres =
      size_warnings_of([](Config& c) { c.vehicle.front_axle = 175.0, c.vehicle.rear_axle = 85.0; });
  EXPECT_THAT(millimetres, Contains(Named("mass_unlike_a_car", "on a wheelbase of 260 m")));
}

}  // namespace
}  // namespace odomd::daemon::config_databases_test
