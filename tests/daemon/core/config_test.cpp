// The values of a configuration, and of the command line options with the same meaning.
#include "daemon/core/config.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include "can_protocol/decode/units.hpp"
#include "config_files.hpp"
#include "daemon/core/config_keys.hpp"

namespace odomd::daemon::config_test {
namespace {

using diagnostics::Named;
using estimator::Driven;
using estimator::Source;
using testing::FieldsAre;
using testing::Optional;

/// A binding in words; defaults are left out.
std::string text_of(const can::SignalBinding& binding) {
  EXPECT_EQ(estimator::source_names.at(binding.channel), binding.role);
  std::string text = fmt::format("{}: {}.{} [{}]", binding.role, binding.message,
                                 fmt::join(binding.signals, "+"), can::unit_name(binding.unit));
  const auto add = [&](bool is_given, std::string_view name, const auto&... values) {
    if (!is_given) return;
    text += fmt::format(", {}", name);
    (..., (text += fmt::format(" {}", values)));
  };
  add(!binding.bus.empty(), "bus", binding.bus);
  add(binding.source.has_value(), "source", binding.source.value_or(0));
  add(binding.radius_m != 0.0, "radius", binding.radius_m);
  add(binding.ratio != 1.0, "ratio", binding.ratio);
  add(binding.scale != 1.0, "scale", binding.scale);
  add(binding.offset != 0.0, "offset", binding.offset);
  if (const auto& sign = binding.sign) add(true, "sign", sign->signal, sign->negative);
  for (const can::ValidWhen& when : binding.valid_when)
    add(true, "valid when", when.signal,
        can::comparison_names.at(static_cast<std::size_t>(when.comparison)), when.value);
  if (const auto& unless = binding.unless_raw)
    add(true, "unless", static_cast<int>(unless->pattern),
        fmt::format("{}", fmt::join(unless->values, " ")));
  add(binding.forward.has_value(), "forward", binding.forward.value_or(0.0));
  add(binding.reverse.has_value(), "reverse", binding.reverse.value_or(0.0));
  add(binding.latency_ns != 0, "latency", binding.latency_ns);
  return text;
}

constexpr auto every_key = R"(
steering = { delay = 0.06, lag = 0.1, rate_limit = 3 }
reference = { lever_arm = [-0.2, 0.1, 0.0] }
imu = { position = [0.05, -0.01], yaw = -0.2, roll_gradient = 0.12, pitch_gradient = 0.05 }
initial = { pose = [1, 2.0, 0.5] }
realtime = { period = 0.01, priority = 60, cpu = 3 }
shm = { name = "/test", mode = "0640", group = "odom" }
status = { socket = "status.sock", socket_mode = 0o660, socket_group = "status" }
record = { socket = "record.sock" }
log = { file = "log/odomd.log", level = "debug" }

[vehicle]
mass = 3.5
front_axle = 0.2
rear_axle = 0.1
yaw_inertia = 0.03
cornering_stiffness_front = 25.0
cornering_stiffness_rear = 65
track_width = 0.18
grip_front = 9.5
grip_rear = 8.5
driven = "front"

[can]
source = "can0"
dbc = "car.dbc"
timestamps = "hardware"
receive_buffer = 2097152

[can.e2e]
IMU_01 = { profile = "P01", data_id = 0x1A0, data_id_mode = "LOW", crc = "IMU_CRC", counter = "IMU_BZ" }
WHEEL.profile = "p22"
WHEEL.data_id_list = [0, 1, 2, 3, 4, 5, 6, 7, 8, 9, 10, 11, 12, 13, 14, 255]
WHEEL.crc = "CRC"
WHEEL.counter = "BZ"
WHEEL.max_delta_counter = 1
OFF = { profile = "none", data_id = 1, crc = "CRC", counter = "BZ" }

[can.signals]
yaw_rate = { message = "IMU_01", signal = "YawRate", unit = "degrees/second", latency = 0.015, sigma = 0.04, sign = { signal = "Minus", negative = 1 }, source = 0x0B }
accel_x = { message = "IMU_01", signal = "AccX", unit = "1", scale = 2.5 }
accel_y = { message = "IMU_01", signal = "AccY", unit = "g", scale = -1.0 }
wheel_rear_left = { message = "WHEEL", signal = "RL", unit = "m/s", valid_when = [{ signal = "RL_FAULT", equals = 0 }, { signal = "RL_Q", below = 2.5 }], unless_raw = [65535, -1] }
wheel_rear_right = { message = "WHEEL", signal = "RR", unit = "kph", bus = "can0", dead_band = 0.3 }
motor = { message = "MOTOR", signal = "N", unit = "erpm", radius = 0.033, ratio = 9.5, pole_pairs = 2, unless_raw = "all_ones" }
steering = { message = "STEER", sum = ["ANGLE", "FRACTION"], unit = "°", scale = 0.0592, offset = 0.01, timeout = 0.5 }
direction = { message = "GEAR", signal = "Dir", forward = 1, reverse = 2 }

[camera]
socket = "/run/odomd/camera.sock"
socket_mode = 0o600
socket_group = "odom"
lever_arm = [0.1, 0.0, 0.5]
max_latency = 0.3

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
)";

TEST_F(ConfigTest, ReadsEveryKeyOfTheBus) {
  const CanConfig can = load(every_key).can;
  EXPECT_THAT(can.sources, ElementsAre("can0"));
  EXPECT_THAT(can.dbc, ElementsAre(directory_ / "car.dbc"));
  EXPECT_EQ(can.timestamps, Timestamps::hardware);
  EXPECT_EQ(can.receive_buffer, 2097152);
  using can::DataIdMode;
  using can::E2eProfile;
  std::vector<std::uint8_t> ids{0, 1, 2, 3, 4, 5, 6, 7, 8, 9, 10, 11, 12, 13, 14, 255};
  EXPECT_THAT(
      can.protections,
      ElementsAre(
          FieldsAre("IMU_01", E2eProfile::p01, 0x1A0, DataIdMode::low, IsEmpty(), "IMU_CRC",
                    "IMU_BZ", 3),
          FieldsAre("WHEEL", E2eProfile::p22, 0, DataIdMode::both, ids, "CRC", "BZ", 1),
          FieldsAre("OFF", E2eProfile::none, 1, DataIdMode::both, IsEmpty(), "CRC", "BZ", 3)));
  std::vector<std::string> bindings;
  for (const can::SignalBinding& binding : can.bindings) bindings.push_back(text_of(binding));
  EXPECT_THAT(
      bindings,
      ElementsAre(
          "yaw_rate: IMU_01.YawRate [deg/s], source 11, sign Minus 1, latency 15000000",
          "accel_x: IMU_01.AccX [1], scale 2.5", "accel_y: IMU_01.AccY [g], scale -1",
          "wheel_rear_left: WHEEL.RL [m/s], valid when RL_FAULT equals 0, valid when RL_Q below "
          "2.5, unless 0 65535 -1",
          "wheel_rear_right: WHEEL.RR [km/h], bus can0",
          "motor: MOTOR.N [erpm], radius 0.033, ratio 19, unless 2 ",  // 9.5 · 2 pole pairs
          "steering: STEER.ANGLE+FRACTION [deg], scale 0.0592, offset 0.01",
          "direction: GEAR.Dir [1], forward 1, reverse 2"));
  // The other time-outs are set later, from the database.
  const auto settings = [&](Source source) { return can.signals[estimator::index_of(source)]; };
  EXPECT_THAT(settings(Source::yaw_rate), FieldsAre(true, 0.04, 0, 0.0));
  EXPECT_THAT(settings(Source::steering), FieldsAre(true, 0.02, 500'000'000, 0.0));
  EXPECT_THAT(settings(Source::wheel_rear_right), FieldsAre(true, 0.05, 0, 0.3));
  EXPECT_THAT(settings(Source::wheel_rear), FieldsAre(false, 0.0, 0, 0.0));
}

TEST_F(ConfigTest, ReadsEveryKeyOfTheOtherTables) {
  const Config config = load(every_key);
  EXPECT_THAT(config.vehicle, FieldsAre(3.5, 0.2, 0.1, 0.03, 25.0, 65.0, 0.18, 9.5, 8.5,
                                        FieldsAre(0.06, 0.1, 3.0), Driven::front));
  EXPECT_THAT(config.camera, FieldsAre(true, FieldsAre("/run/odomd/camera.sock", 0600U, "odom"),
                                       ElementsAre(0.1, 0.0, 0.5), 0.3));
  EXPECT_THAT(config.reference_lever_arm, Optional(ElementsAre(-0.2, 0.1, 0.0)));
  EXPECT_THAT(config.imu_position, ElementsAre(0.05, -0.01));
  EXPECT_EQ(config.imu_yaw, -0.2);
  EXPECT_EQ(config.roll_gradient, 0.12);
  EXPECT_EQ(config.pitch_gradient, 0.05);
  EXPECT_THAT(config.initial_pose, Optional(FieldsAre(1.0, 2.0, 0.5)));
  EXPECT_EQ(config.model, estimator::Model::kinematic);
  EXPECT_EQ(config.window_s, 0.3);
  EXPECT_EQ(config.camera_gate, 11.3);
  const estimator::Tuning& tuning = config.tuning;
  EXPECT_THAT(
      (std::array{tuning.gyro_bias_walk, tuning.gyro_scale_walk, tuning.accel_bias_walk,
                  tuning.wheel_scale_walk, tuning.steering_offset_walk, tuning.stiffness_scale_walk,
                  tuning.front_angle, tuning.side_slip, tuning.wheel_radius, tuning.wheel_slip}),
      ElementsAre(1e-5, 2e-5, 3e-5, 4e-5, 5e-5, 6e-5, 0.3, 0.05, 0.0, 0.01));
  EXPECT_THAT(config.paper_noise, FieldsAre(ElementsAre(0.1, 0.02, 0.03), ElementsAre(0.2, 0.3)));
  EXPECT_THAT(config.realtime, FieldsAre(10'000'000, 60, 3));
  EXPECT_THAT(config.shm, FieldsAre("/test", 0640U, "odom"));
  EXPECT_THAT(config.status, FieldsAre(directory_ / "status.sock", 0660U, "status"));
  EXPECT_EQ(config.record.path, directory_ / "record.sock");
  EXPECT_THAT(config.log, FieldsAre(directory_ / "log/odomd.log", "debug"));
  EXPECT_THAT(config.warnings, IsEmpty());
}

// configuration_doc_test.cpp compares the other defaults.
TEST_F(ConfigTest, DefaultsToTheReferenceCarWithAWarning) {
  Config config = load(small_bus);
  place_sockets(config, "/run/odomd");
  EXPECT_THAT(config.vehicle, FieldsAre(2.985, 0.175, 0.085, 0.0283384, 20.0, 60.0, 0.16, 0.0, 0.0,
                                        FieldsAre(0.0, 0.0, 0.0), Driven::rear));
  EXPECT_THAT(config.warnings, ElementsAre(Named("reference_car")));
  EXPECT_EQ(config.record.mode, 0666U) << "who may read the pose may record";
  config.shm.mode = 0640;
  place_sockets(config, "/run/odomd");
  EXPECT_EQ(config.record.mode, 0660U);
  EXPECT_THAT(config.can.sources, IsEmpty());
  EXPECT_FALSE(config.camera.configured || config.reference_lever_arm || config.initial_pose ||
               config.roll_gradient || config.pitch_gradient);
}

TEST_F(ConfigTest, GivesTheFilterItsSettings) {
  const auto settings = filter_settings(load(every_key));
  EXPECT_EQ(settings.vehicle.mass, 3.5);
  EXPECT_EQ(settings.period_s, 0.01);
  EXPECT_EQ(settings.dead_band[estimator::index_of(Source::wheel_rear_right)], 0.3);
  // Zero is a value (no lean), not an unknown gradient. [steering] needs no [vehicle].
  const auto others =
      filter_settings(load("imu.roll_gradient = 0\nsteering.lag = 0.1\n" + small_bus));
  EXPECT_EQ(others.roll_gradient, 0.0);
  EXPECT_FALSE(others.pitch_gradient.has_value());
  EXPECT_EQ(others.vehicle.steering.lag_s, 0.1);
}

TEST_F(ConfigTest, ResolvesLogsNextToTheFileButNotInterfaces) {
  scratch_.write("drive.log", "");
  const Config config = load(R"(
[can]
source = ["can0", "drive.log", "logs/other.log", "-", "/tmp/x.log"]
dbc = ["a.dbc", "/etc/b.dbc"]
signals.motor = { message = "M", signal = "S", unit = "m/s" }
)");
  EXPECT_THAT(config.can.sources,
              ElementsAre("can0", (directory_ / "drive.log").string(),
                          (directory_ / "logs/other.log").string(), "-", "/tmp/x.log"));
  EXPECT_THAT(config.can.dbc, ElementsAre(directory_ / "a.dbc", "/etc/b.dbc"));
}

TEST(ConfigKeys, AreFoundByPathAndHaveAGroup) {
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

// Command-line values

TEST(ParsePose, TakesThreeNumbersAndNothingElse) {
  EXPECT_THAT(parse_pose("1.5,-2,3e-1"), FieldsAre(1.5, -2.0, 0.3));
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
