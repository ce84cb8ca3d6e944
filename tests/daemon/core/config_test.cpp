// The values of a configuration, and of the command line options with the same meaning.
#include "daemon/core/config.hpp"

#include <fstream>

#include "config_files.hpp"
#include "daemon/core/config_keys.hpp"
#include "tests/diagnostics.hpp"

namespace odomd::daemon::config_test {
namespace {

using estimator::Source;

constexpr auto reference_car = R"(
[vehicle]
mass = 2.985
front_axle = 0.175
rear_axle = 0.085
yaw_inertia = 0.0283384
cornering_stiffness_front = 20.0
cornering_stiffness_rear = 60
track_width = 0.16
)";

TEST_F(ConfigTest, TakesUnitsInTheSpellingsOfDatabases) {
  const auto unit_of = [this](const std::string& role, const std::string& unit) {
    const Config config =
        load(std::string(reference_car) + "[can]\ndbc = \"car.dbc\"\n[can.signals]\n" + role +
             R"( = { message = "M", signal = "S", unit = ")" + unit + R"(", scale = 1.0 })");
    return config.can.bindings.front().unit;
  };
  EXPECT_EQ(unit_of("yaw_rate", "°/s"), can::Unit::deg_per_s);
  EXPECT_EQ(unit_of("yaw_rate", "degrees/second"), can::Unit::deg_per_s);
  EXPECT_EQ(unit_of("steering", "degrees"), can::Unit::deg);
  EXPECT_EQ(unit_of("steering", "°"), can::Unit::deg);
  EXPECT_EQ(unit_of("steering", "1"), can::Unit::none);
  EXPECT_EQ(unit_of("wheel_rear", "kph"), can::Unit::km_per_h);
  EXPECT_EQ(unit_of("accel_x", "m/s²"), can::Unit::m_per_s2);
  EXPECT_THROW(unit_of("wheel_rear", "mph"), ConfigError);
  EXPECT_THROW(unit_of("wheel_rear", "°/s"), ConfigError);
}

TEST_F(ConfigTest, ReadsEveryTableOfTheDocumentedExample) {
  const Config config = load(R"(
[vehicle]
mass = 3.5
front_axle = 0.2
rear_axle = 0.1
yaw_inertia = 0.03
cornering_stiffness_front = 25.0
cornering_stiffness_rear = 65.0
track_width = 0.18
grip_front = 9.5
grip_rear = 8.5
driven = "front"

[steering]
delay = 0.06
lag = 0.1
rate_limit = 3

[can]
source = "can0"
dbc = "car.dbc"
timestamps = "hardware"
receive_buffer = 2097152

[can.e2e]
IMU_01 = { profile = "P01", data_id = 0x1A0, data_id_mode = "LOW", crc = "IMU_01_CRC", counter = "IMU_01_BZ" }

[can.signals]
yaw_rate          = { message = "IMU_01", signal = "YawRate", unit = "rad/s", latency = 0.015, sigma = 0.04, sign = { signal = "Minus", negative = 1 }, source = 0x0B }
accel_x           = { message = "IMU_01", signal = "AccX", unit = "m/s2" }
accel_y           = { message = "IMU_01", signal = "AccY", unit = "g", scale = -1.0 }
wheel_rear_left   = { message = "WHEEL", signal = "RL", unit = "m/s", valid_when = [{ signal = "RL_FAULT", equals = 0 }, { signal = "RL_Q", below = 2.5 }], unless_raw = [65535, -1] }
wheel_rear_right  = { message = "WHEEL", signal = "RR", unit = "km/h", bus = "can0", dead_band = 0.3 }
motor             = { message = "MOTOR", signal = "N", unit = "erpm", radius = 0.033, ratio = 9.5, pole_pairs = 2, unless_raw = "all_ones" }
steering          = { message = "STEER", sum = ["ANGLE", "FRACTION"], unit = "deg", scale = 0.0592, offset = 0.01, timeout = 0.5 }
direction         = { message = "GEAR", signal = "Dir", forward = 1, reverse = 2 }

[camera]
socket = "/run/odomd/camera.sock"
socket_mode = 0o600
socket_group = "odom"
lever_arm = [0.1, 0.0, 0.5]
max_latency = 0.3

[reference]
lever_arm = [-0.2, 0.1, 0.0]

[imu]
position = [0.05, -0.01]
yaw = -0.2
roll_gradient = 0.12
pitch_gradient = 0.05

[initial]
pose = [1, 2.0, 0.5]

[filter]
model = "kinematic"
window = 0.3
camera_gate = 11.3
gyro_bias_walk = 1e-5
gyro_scale_walk = 2e-5
accel_bias_walk = 3e-5
wheel_scale_walk = 4e-5
steering_offset_walk = 5e-5
stiffness_scale_walk = 6e-5
front_angle_error = 0.3
side_slip_error = 0.05
wheel_radius_error = 0
wheel_slip = 0.01
paper_q = [0.1, 0.02, 0.03]
paper_r = [0.2, 0.3]

[realtime]
period = 0.01
priority = 60
cpu = 3

[shm]
name = "/test"
mode = "0640"
group = "odom"

[status]
socket = "status.sock"

[log]
file = "log/odomd.log"
level = "debug"
)");
  EXPECT_EQ(config.vehicle.mass, 3.5);
  EXPECT_EQ(config.vehicle.track_width, 0.18);
  EXPECT_EQ(config.vehicle.grip_front, 9.5);
  EXPECT_EQ(config.vehicle.grip_rear, 8.5);
  EXPECT_EQ(config.vehicle.driven, estimator::Driven::front);
  EXPECT_EQ(config.vehicle.steering.delay_s, 0.06);
  EXPECT_EQ(config.vehicle.steering.lag_s, 0.1);
  EXPECT_EQ(config.vehicle.steering.rate_limit, 3.0);
  EXPECT_THAT(config.can.sources, ElementsAre("can0"));
  EXPECT_THAT(config.can.dbc, ElementsAre(directory_ / "car.dbc"));
  EXPECT_EQ(config.can.timestamps, Timestamps::hardware);
  EXPECT_EQ(config.can.receive_buffer, 2097152);

  ASSERT_EQ(config.can.protections.size(), 1U);
  const auto& protection = config.can.protections[0];
  EXPECT_EQ(protection.message, "IMU_01");
  EXPECT_EQ(protection.profile, can::E2eProfile::p01);
  EXPECT_EQ(protection.data_id, 0x1A0);
  EXPECT_EQ(protection.data_id_mode, can::DataIdMode::low);
  EXPECT_EQ(protection.crc_signal, "IMU_01_CRC");
  EXPECT_EQ(protection.counter_signal, "IMU_01_BZ");

  ASSERT_EQ(config.can.bindings.size(), 8U);
  const auto& yaw_rate = config.can.bindings[0];
  EXPECT_EQ(yaw_rate.role, "yaw_rate");
  EXPECT_EQ(yaw_rate.channel, static_cast<std::uint16_t>(Source::yaw_rate));
  EXPECT_EQ(yaw_rate.unit, can::Unit::rad_per_s);
  EXPECT_EQ(yaw_rate.latency_ns, 15'000'000);
  const auto& accel_y = config.can.bindings[2];
  EXPECT_EQ(accel_y.unit, can::Unit::g);
  EXPECT_EQ(accel_y.scale, -1.0);
  const auto& wheel = config.can.bindings[3];
  ASSERT_EQ(wheel.valid_when.size(), 2U);
  EXPECT_EQ(wheel.valid_when[0].signal, "RL_FAULT");
  EXPECT_EQ(wheel.valid_when[0].comparison, can::Comparison::equals);
  EXPECT_EQ(wheel.valid_when[0].value, 0.0);
  EXPECT_EQ(wheel.valid_when[1].comparison, can::Comparison::below);
  EXPECT_EQ(wheel.valid_when[1].value, 2.5);
  ASSERT_TRUE(wheel.unless_raw && wheel.unless_raw->pattern == can::UnlessRaw::Pattern::listed);
  EXPECT_THAT(wheel.unless_raw->values, ElementsAre(65535, -1));
  ASSERT_TRUE(config.can.bindings[0].sign);
  EXPECT_EQ(config.can.bindings[0].sign->signal, "Minus");
  EXPECT_EQ(config.can.bindings[0].sign->negative, 1.0);
  EXPECT_EQ(config.can.bindings[0].source, 0x0B);
  EXPECT_EQ(config.can.bindings[4].bus, "can0");
  EXPECT_EQ(config.can.bindings[4].unit, can::Unit::km_per_h);
  const auto& motor = config.can.bindings[5];
  EXPECT_EQ(motor.unit, can::Unit::erpm);
  EXPECT_EQ(motor.radius_m, 0.033);
  EXPECT_EQ(motor.ratio, 19.0);  // includes the pole pairs
  EXPECT_EQ(motor.unless_raw.value().pattern, can::UnlessRaw::Pattern::all_ones);
  const auto& steering = config.can.bindings[6];
  EXPECT_THAT(steering.signals, ElementsAre("ANGLE", "FRACTION"));
  EXPECT_EQ(steering.scale, 0.0592);
  EXPECT_EQ(steering.offset, 0.01);
  const auto& direction = config.can.bindings[7];
  EXPECT_EQ(direction.forward, 1.0);
  EXPECT_EQ(direction.reverse, 2.0);

  const auto signal = [&](Source source) {
    return config.can.signals[static_cast<std::size_t>(source)];
  };
  EXPECT_TRUE(signal(Source::yaw_rate).configured);
  EXPECT_EQ(signal(Source::yaw_rate).sigma, 0.04);
  EXPECT_EQ(signal(Source::yaw_rate).timeout_ns, 0);  // set later, from the database
  EXPECT_EQ(signal(Source::steering).timeout_ns, 500'000'000);
  EXPECT_EQ(signal(Source::wheel_rear_right).dead_band, 0.3);
  EXPECT_EQ(signal(Source::motor).dead_band, 0.0);
  EXPECT_EQ(filter_settings(config).dead_band[estimator::index_of(Source::wheel_rear_right)], 0.3);
  EXPECT_FALSE(signal(Source::wheel_rear).configured);

  EXPECT_TRUE(config.camera.configured);
  EXPECT_EQ(config.camera.socket, "/run/odomd/camera.sock");
  EXPECT_EQ(config.camera.socket_mode, 0600U);
  EXPECT_EQ(config.camera.socket_group, "odom");
  EXPECT_THAT(config.camera.lever_arm, ElementsAre(0.1, 0.0, 0.5));
  EXPECT_EQ(config.camera.max_latency_s, 0.3);
  EXPECT_THAT(config.reference_lever_arm, testing::Optional(ElementsAre(-0.2, 0.1, 0.0)));
  EXPECT_THAT(config.imu_position, ElementsAre(0.05, -0.01));
  EXPECT_EQ(config.imu_yaw, -0.2);
  EXPECT_EQ(config.roll_gradient, 0.12);
  EXPECT_EQ(config.pitch_gradient, 0.05);
  ASSERT_TRUE(config.initial_pose.has_value());
  EXPECT_EQ(config.initial_pose->x, 1.0);
  EXPECT_EQ(config.initial_pose->yaw, 0.5);
  EXPECT_EQ(config.model, estimator::Model::kinematic);
  EXPECT_EQ(config.window_s, 0.3);
  EXPECT_EQ(config.camera_gate, 11.3);
  EXPECT_EQ(config.tuning.gyro_bias_walk, 1e-5);
  EXPECT_EQ(config.tuning.gyro_scale_walk, 2e-5);
  EXPECT_EQ(config.tuning.accel_bias_walk, 3e-5);
  EXPECT_EQ(config.tuning.wheel_scale_walk, 4e-5);
  EXPECT_EQ(config.tuning.steering_offset_walk, 5e-5);
  EXPECT_EQ(config.tuning.stiffness_scale_walk, 6e-5);
  EXPECT_EQ(config.tuning.front_angle, 0.3);
  EXPECT_EQ(config.tuning.side_slip, 0.05);
  EXPECT_EQ(config.tuning.wheel_radius, 0.0);
  EXPECT_EQ(config.tuning.wheel_slip, 0.01);
  EXPECT_THAT(config.paper_noise.Q, ElementsAre(0.1, 0.02, 0.03));
  EXPECT_THAT(config.paper_noise.R, ElementsAre(0.2, 0.3));
  EXPECT_EQ(config.realtime.period_ns, 10'000'000);
  EXPECT_EQ(filter_settings(config).period_s, 0.01);
  EXPECT_EQ(config.realtime.priority, 60);
  EXPECT_EQ(config.realtime.cpu, 3);
  EXPECT_EQ(config.shm.name, "/test");
  EXPECT_EQ(config.shm.mode, 0640U);
  EXPECT_EQ(config.shm.group, "odom");
  EXPECT_EQ(config.status.socket, directory_ / "status.sock");
  EXPECT_EQ(config.log.file, directory_ / "log/odomd.log");
  EXPECT_EQ(config.log.level, "debug");
  EXPECT_THAT(config.warnings, IsEmpty());
}

TEST(ConfigKeys, AreFoundByTableAndNameAndHaveTheirGroup) {
  const auto group = [](std::string_view path) { return config_key(path)->group; };
  EXPECT_EQ(config_key("camera.lever_arm[2]")->name, "lever_arm");
  EXPECT_EQ(config_key("vehicle.driven")->table, "vehicle");
  for (const auto* none : {"", "vehicle", "mass", "vehicle.mas", "can.signals.motor.scale"})
    EXPECT_EQ(config_key(none), nullptr) << none;
  EXPECT_EQ(group("vehicle.grip_rear"), group("vehicle.cornering_stiffness_rear"));
  EXPECT_NE(group("vehicle.grip_front"), group("vehicle.grip_rear"));
  EXPECT_EQ(group("steering.lag"), group("steering.rate_limit"));
  EXPECT_EQ(group("imu.yaw"), group("imu.position[0]"));
  EXPECT_EQ(group("vehicle.mass"), "");
}

TEST_F(ConfigTest, TakesDefaultsWhereTheFileIsSilent) {
  const Config config = load(std::string(reference_car) + small_bus);
  EXPECT_THAT(config.can.sources, IsEmpty());
  EXPECT_FALSE(config.camera.configured);
  EXPECT_FALSE(config.reference_lever_arm);
  EXPECT_FALSE(config.initial_pose.has_value());
  EXPECT_EQ(config.model, estimator::Model::full);
  EXPECT_EQ(config.vehicle.grip_front, 0.0);
  EXPECT_EQ(config.vehicle.grip_rear, 0.0);
  EXPECT_EQ(config.vehicle.driven, estimator::Driven::rear);
  EXPECT_EQ(config.vehicle.steering.delay_s, 0.0);
  EXPECT_EQ(config.vehicle.steering.lag_s, 0.0);
  EXPECT_EQ(config.vehicle.steering.rate_limit, 0.0);
  EXPECT_FALSE(config.roll_gradient.has_value());
  EXPECT_FALSE(config.pitch_gradient.has_value());
  EXPECT_EQ(config.realtime.period_ns, 5'000'000);
  EXPECT_EQ(config.shm.name, "/odomd");
  EXPECT_GT(config.can.signals[static_cast<std::size_t>(Source::wheel_rear)].sigma, 0.0);
}

TEST_F(ConfigTest, PutsTheServoIntoTheReferenceCarToo) {
  const Config config = load(std::string("[steering]\nlag = 0.1\n") + small_bus);
  EXPECT_EQ(config.vehicle.steering.lag_s, 0.1);
  EXPECT_EQ(filter_settings(config).vehicle.steering.lag_s, 0.1);
}

// Zero is a value: a car that does not lean, not an unknown gradient.
TEST_F(ConfigTest, GivesTheFilterTheGradientsThatAreConfigured) {
  const Config config = load(std::string("[imu]\nroll_gradient = 0\n") + small_bus);
  EXPECT_EQ(filter_settings(config).roll_gradient, 0.0);
  EXPECT_FALSE(filter_settings(config).pitch_gradient.has_value());
}

TEST_F(ConfigTest, WarnsWhereTheCarIsNotDescribed) {
  const Config config = load(small_bus);
  EXPECT_THAT(config.warnings, ElementsAre(diagnostics::Named("reference_car")));
}

TEST_F(ConfigTest, ResolvesLogsNextToTheFileButNotInterfaces) {
  std::ofstream(directory_ / "drive.log") << "";
  const Config config = load(R"(
[can]
source = ["can0", "drive.log", "logs/other.log", "-", "/tmp/x.log"]
dbc = ["a.dbc", "/etc/b.dbc"]
[can.signals]
motor = { message = "M", signal = "S", unit = "m/s" }
)");
  EXPECT_THAT(config.can.sources,
              ElementsAre("can0", (directory_ / "drive.log").string(),
                          (directory_ / "logs/other.log").string(), "-", "/tmp/x.log"));
  EXPECT_THAT(config.can.dbc, ElementsAre(directory_ / "a.dbc", "/etc/b.dbc"));
}

TEST_F(ConfigTest, ReadsAProtectionByDataIdList) {
  const Config config = load(std::string(small_bus) + R"(
[can.e2e.WHEEL]
profile = "p22"
data_id_list = [0, 1, 2, 3, 4, 5, 6, 7, 8, 9, 10, 11, 12, 13, 14, 255]
crc = "CRC"
counter = "BZ"
max_delta_counter = 1
)");
  ASSERT_EQ(config.can.protections.size(), 1U);
  EXPECT_EQ(config.can.protections[0].profile, can::E2eProfile::p22);
  EXPECT_EQ(config.can.protections[0].data_id_list.size(), 16U);
  EXPECT_EQ(config.can.protections[0].data_id_list.back(), 255);
  EXPECT_EQ(config.can.protections[0].max_delta_counter, 1);
}

TEST_F(ConfigTest, ReadsAProtectionThatIsSwitchedOffForAWhile) {
  const Config config = load(std::string(small_bus) + R"(
[can.e2e.WHEEL]
profile = "none"  # "P01"
data_id = 1
crc = "CRC"
counter = "BZ"
)");
  EXPECT_EQ(config.can.protections.at(0).profile, can::E2eProfile::none);
}

// Words of the command line
// ------------------------------------------------------------------------

TEST(ParsePose, TakesThreeNumbers) {
  const auto pose = parse_pose("1.5,-2,3e-1");
  EXPECT_EQ(pose.x, 1.5);
  EXPECT_EQ(pose.y, -2.0);
  EXPECT_EQ(pose.yaw, 0.3);
}

TEST(ParsePose, RefusesAnythingElse) {
  for (const auto* text :
       {"", "1", "1,2", "1,2,", "1,2,3,4", "1, 2,3", "a,b,c", "1,2,nan", "1,2,3 "})
    EXPECT_THROW(static_cast<void>(parse_pose(text)), std::invalid_argument) << text;
}

TEST(ParseModel, KnowsEveryModelByItsName) {
  for (const auto name : estimator::model_names) EXPECT_EQ(name_of(parse_model(name)), name);
  EXPECT_THROW(static_cast<void>(parse_model("particle")), std::invalid_argument);
}

}  // namespace
}  // namespace odomd::daemon::config_test
