// What a configuration means, and what is said of one that means nothing. Every error is checked by
// its whole text: it is what the user has to go by.
#include "daemon/config.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <unistd.h>

#include <fstream>
#include <string>

namespace odomd::daemon {
namespace {

using estimator::Source;
using testing::ElementsAre;
using testing::HasSubstr;
using testing::IsEmpty;

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

constexpr auto small_bus = R"(
[can]
dbc = "car.dbc"
[can.signals]
wheel_rear = { message = "WHEEL", signal = "REAR", unit = "m/s" }
)";

class ConfigTest : public testing::Test {
 protected:
  void SetUp() override {
    std::string name = testing::TempDir() + "odomd_config_XXXXXX";
    ASSERT_NE(mkdtemp(name.data()), nullptr);
    directory_ = std::filesystem::canonical(name);
    file_ = directory_ / "car.toml";
  }
  void TearDown() override { std::filesystem::remove_all(directory_); }

  void write(const std::string& text) const { std::ofstream(file_, std::ios::binary) << text; }

  [[nodiscard]] Config load(const std::string& text) const {
    write(text);
    return load_config(file_);
  }

  /// The error, without the directory; empty where there was none.
  [[nodiscard]] std::string error_of(const std::string& text) const {
    write(text);
    return error();
  }
  [[nodiscard]] std::string error() const {
    try {
      static_cast<void>(load_config(file_));
    } catch (const ConfigError& error) {
      std::string what = error.what();
      EXPECT_EQ(what.find('\n'), std::string::npos) << what;
      const auto prefix = directory_.string() + "/";
      EXPECT_EQ(what.rfind(prefix, 0), 0U) << what;
      return what.substr(prefix.size());
    }
    return "";
  }

  std::filesystem::path directory_;
  std::filesystem::path file_;
};

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

[can]
source = "can0"
dbc = "car.dbc"
timestamps = "hardware"
receive_buffer = 2097152

[can.e2e]
IMU_01 = { profile = "P01", data_id = 0x1A0, data_id_mode = "BOTH", crc = "IMU_01_CRC", counter = "IMU_01_BZ" }

[can.signals]
yaw_rate          = { message = "IMU_01", signal = "YawRate", unit = "rad/s", latency = 0.015, sigma = 0.04 }
accel_x           = { message = "IMU_01", signal = "AccX", unit = "m/s2" }
accel_y           = { message = "IMU_01", signal = "AccY", unit = "g", scale = -1.0 }
wheel_rear_left   = { message = "WHEEL", signal = "RL", unit = "m/s", valid_when = { signal = "RL_FAULT", equals = 0 } }
wheel_rear_right  = { message = "WHEEL", signal = "RR", unit = "km/h", bus = "can0" }
motor             = { message = "MOTOR", signal = "N", unit = "rpm", radius = 0.033, ratio = 9.5 }
steering          = { message = "STEER", sum = ["ANGLE", "FRACTION"], unit = "deg", scale = 0.0592, offset = 0.01, timeout = 0.5 }
direction         = { message = "GEAR", signal = "Dir", forward = 1, reverse = 2 }

[camera]
socket = "/run/odomd/camera.sock"
socket_mode = 0o600
socket_group = "odom"
lever_arm = [0.1, 0.0, 0.5]
max_latency = 0.3

[imu]
position = [0.05, -0.01]
yaw = -0.2

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
tyre_force_error = 2
yaw_moment_error = 7
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
  EXPECT_THAT(config.can.sources, ElementsAre("can0"));
  EXPECT_THAT(config.can.dbc, ElementsAre(directory_ / "car.dbc"));
  EXPECT_EQ(config.can.timestamps, Timestamps::hardware);
  EXPECT_EQ(config.can.receive_buffer, 2097152);

  ASSERT_EQ(config.can.protections.size(), 1U);
  const auto& protection = config.can.protections[0];
  EXPECT_EQ(protection.message, "IMU_01");
  EXPECT_EQ(protection.profile, can::E2eProfile::p01);
  EXPECT_EQ(protection.data_id, 0x1A0);
  EXPECT_EQ(protection.data_id_mode, can::DataIdMode::both);
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
  ASSERT_TRUE(wheel.valid_when.has_value());
  EXPECT_EQ(wheel.valid_when->signal, "RL_FAULT");
  EXPECT_EQ(wheel.valid_when->equals, 0.0);
  EXPECT_EQ(config.can.bindings[4].bus, "can0");
  EXPECT_EQ(config.can.bindings[4].unit, can::Unit::km_per_h);
  const auto& motor = config.can.bindings[5];
  EXPECT_EQ(motor.unit, can::Unit::rpm);
  EXPECT_EQ(motor.radius_m, 0.033);
  EXPECT_EQ(motor.ratio, 9.5);
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
  EXPECT_EQ(signal(Source::yaw_rate).timeout_ns, 0);  // from the database, later
  EXPECT_EQ(signal(Source::steering).timeout_ns, 500'000'000);
  EXPECT_FALSE(signal(Source::wheel_rear).configured);

  EXPECT_TRUE(config.camera.configured);
  EXPECT_EQ(config.camera.socket, "/run/odomd/camera.sock");
  EXPECT_EQ(config.camera.socket_mode, 0600U);
  EXPECT_EQ(config.camera.socket_group, "odom");
  EXPECT_THAT(config.camera.lever_arm, ElementsAre(0.1, 0.0, 0.5));
  EXPECT_EQ(config.camera.max_latency_s, 0.3);
  EXPECT_THAT(config.imu_position, ElementsAre(0.05, -0.01));
  EXPECT_EQ(config.imu_yaw, -0.2);
  ASSERT_TRUE(config.initial_pose.has_value());
  EXPECT_EQ(config.initial_pose->x, 1.0);
  EXPECT_EQ(config.initial_pose->yaw, 0.5);
  EXPECT_EQ(config.model, estimator::Model::kinematic);
  EXPECT_EQ(config.window_s, 0.3);
  EXPECT_EQ(config.camera_gate, 11.3);
  EXPECT_EQ(config.full_noise.gyro_bias, 1e-5);
  EXPECT_EQ(config.full_noise.gyro_scale, 2e-5);
  EXPECT_EQ(config.full_noise.accel_bias, 3e-5);
  EXPECT_EQ(config.full_noise.wheel_scale, 4e-5);
  EXPECT_EQ(config.full_noise.steering_offset, 5e-5);
  EXPECT_EQ(config.full_noise.stiffness_scale, 6e-5);
  EXPECT_EQ(config.full_noise.front_force, 2.0);
  EXPECT_EQ(config.full_noise.yaw_moment, 7.0);
  EXPECT_EQ(config.wheel_noise.radius, 0.0);
  EXPECT_EQ(config.wheel_noise.driven_slip, 0.01);
  EXPECT_THAT(config.paper_noise.Q, ElementsAre(0.1, 0.02, 0.03));
  EXPECT_THAT(config.paper_noise.R, ElementsAre(0.2, 0.3));
  EXPECT_EQ(config.realtime.period_ns, 10'000'000);
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

TEST_F(ConfigTest, TakesDefaultsWhereTheFileIsSilent) {
  const Config config = load(std::string(reference_car) + small_bus);
  EXPECT_THAT(config.can.sources, IsEmpty());
  EXPECT_FALSE(config.camera.configured);
  EXPECT_FALSE(config.initial_pose.has_value());
  EXPECT_EQ(config.model, estimator::Model::full);
  EXPECT_EQ(config.realtime.period_ns, 5'000'000);
  EXPECT_EQ(config.shm.name, "/odomd");
  EXPECT_GT(config.can.signals[static_cast<std::size_t>(Source::wheel_rear)].sigma, 0.0);
}

TEST_F(ConfigTest, WarnsWhereTheCarIsNotDescribed) {
  const Config config = load(small_bus);
  EXPECT_THAT(config.warnings, ElementsAre(HasSubstr("no [vehicle]: the reference car")));
}

TEST_F(ConfigTest, TakesLogsBesideTheFileAndLeavesInterfacesAlone) {
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

// Files that are no configuration
// ------------------------------------------------------------------

TEST_F(ConfigTest, RefusesAFileThatIsNotThere) {
  EXPECT_EQ(error(), "car.toml: cannot be read: No such file or directory");
}

TEST_F(ConfigTest, RefusesADirectory) {
  std::filesystem::create_directory(file_);
  EXPECT_EQ(error(), "car.toml: is a directory, not a configuration");
}

TEST_F(ConfigTest, RefusesWhatIsNotToml) {
  EXPECT_THAT(error_of("[vehicle]\nmass = = 3\n"), testing::StartsWith("car.toml:2: not TOML: "));
  EXPECT_THAT(error_of("a = \"\xff\xfe\"\n"), testing::StartsWith("car.toml:1: not TOML: "));
  EXPECT_THAT(error_of("[vehicle\nx"), testing::StartsWith("car.toml:1: not TOML: "));
  EXPECT_THAT(error_of("a = 1\na = 2\n"), testing::StartsWith("car.toml:2: not TOML: "));
  EXPECT_THAT(error_of(std::string(5000, '[')), testing::StartsWith("car.toml:1: not TOML: "));
}

TEST_F(ConfigTest, RefusesNulBytes) {
  EXPECT_EQ(error_of(std::string("[vehicle]\nmass\0 = 3\n", 20)),
            "car.toml:2: holds a NUL byte; the file is damaged or not a text");
}

TEST_F(ConfigTest, RefusesAnEmptyFile) {
  EXPECT_EQ(error_of(""),
            "car.toml:1: can: is missing; say in [can] which database and signals to use");
}

TEST_F(ConfigTest, RefusesAHugeFile) {
  EXPECT_EQ(error_of(std::string((1 << 20) + 1, '\n')),
            "car.toml: is larger than 1 MiB; is this the configuration?");
}

// Every other error, one line each
// -----------------------------------------------------------------

struct Mistake {
  const char* name;
  std::string text;
  const char* error;
};

class ConfigMistake : public ConfigTest, public testing::WithParamInterface<Mistake> {};

TEST_P(ConfigMistake, IsNamedWithItsLineAndMend) {
  EXPECT_EQ(error_of(GetParam().text), GetParam().error);
}

std::string vehicle(const std::string& line) {
  return std::string("[vehicle]\n") + line + small_bus;
}
std::string can(const std::string& lines) {
  return "[can]\ndbc = \"car.dbc\"\n" + lines;
}
std::string signal(const std::string& role, const std::string& rest) {
  return can("[can.signals]\n" + role + R"( = { message = "M")" + rest + " }\n");
}
std::string e2e(const std::string& rest) {
  return can("[can.e2e]\nM = { " + rest + " }\n");
}
std::string also(const std::string& lines) {
  return "# 1\n" + lines + small_bus;
}

const Mistake mistakes[] = {
    {"UnknownTable", also("[vehicel]\n"),
     R"(car.toml:2: vehicel: unknown key; did you mean "vehicle"?)"},
    {"UnknownKey", vehicle("mas = 3"),
     R"(car.toml:2: [vehicle] mas: unknown key; did you mean "mass"?)"},
    {"UnknownKeyNearNothing", also("[initial]\npose = [0, 0, 0]\nqqqqqqqqq = 1\n"),
     R"(car.toml:4: [initial] qqqqqqqqq: unknown key; did you mean "pose"?)"},
    {"NotATable", "vehicle = 3\n", "car.toml:1: vehicle: is a number; it must be a table"},
    {"NegativeMass", vehicle("mass = -1"),
     "car.toml:2: [vehicle] mass: -1 is not possible; it must be greater than 0"},
    {"ZeroMass", vehicle("mass = 0"),
     "car.toml:2: [vehicle] mass: 0 is not possible; it must be greater than 0"},
    {"NanMass", vehicle("mass = nan"),
     "car.toml:2: [vehicle] mass: nan is not possible; it must be greater than 0"},
    {"InfiniteMass", vehicle("mass = inf"),
     "car.toml:2: [vehicle] mass: inf is not possible; it must be greater than 0"},
    {"TextForANumber", vehicle(R"(mass = "3")"),
     "car.toml:2: [vehicle] mass: is a text; it must be a number"},
    {"BooleanForANumber", vehicle("mass = true"),
     "car.toml:2: [vehicle] mass: is true or false; it must be a number"},
    {"HalfACar", vehicle("mass = 3"),
     "car.toml:1: [vehicle] front_axle: is missing; a car is described whole or not at all"},

    {"NoDatabase", "[can]\nsource = \"can0\"\n",
     "car.toml:1: [can] dbc: is missing; name the car's database"},
    {"MisspeltDatabase", "[can]\ndbcs = \"car.dbc\"\n",
     R"(car.toml:2: [can] dbcs: unknown key; did you mean "dbc"?)"},
    {"MisspeltSignals", can("[can.signalz]\n"),
     R"(car.toml:3: [can] signalz: unknown key; did you mean "signals"?)"},
    {"MisspeltCan", "[cam]\n", R"(car.toml:1: cam: unknown key; did you mean "can"?)"},
    {"NoSignals", can(""),
     "car.toml:1: [can] signals: is missing; say in [can.signals] where each role comes from"},
    {"EmptySignals", can("[can.signals]\n"),
     "car.toml:3: [can.signals]: is empty; map at least a wheel speed"},
    {"EmptySource", can("source = \"\"\n"), "car.toml:3: [can] source: holds an empty name"},
    {"NoSourceInList", can("source = []\n"), "car.toml:3: [can] source: is an empty list"},
    {"NumberAsSource", can("source = [1]\n"),
     "car.toml:3: [can] source: is a number; it must be a text in quotes"},
    {"TooManySources",
     can("source = [\"1\", \"2\", \"3\", \"4\", \"5\", \"6\", \"7\", \"8\", \"9\"]\n"),
     "car.toml:3: [can] source: names 9 buses; 8 is the most"},
    {"UnknownTimestamps", can("timestamps = \"hardwear\"\n"),
     R"(car.toml:3: [can] timestamps: "hardwear" is not known; did you mean "hardware"?)"},
    {"TinyReceiveBuffer", can("receive_buffer = 10\n"),
     "car.toml:3: [can] receive_buffer: 10 is not possible; it must be 4096 to 1073741824"},
    {"FractionForAWhole", can("receive_buffer = 5000.5\n"),
     "car.toml:3: [can] receive_buffer: is a fraction; it must be a whole number"},

    {"UnknownRole", signal("yaw_rat", R"(, signal = "S", unit = "rad/s")"),
     R"(car.toml:4: [can.signals] yaw_rat: unknown role; did you mean "yaw_rate"?)"},
    {"CameraIsNoSignal", signal("camera", R"(, signal = "S", unit = "rad/s")"),
     "car.toml:4: [can.signals] camera: a camera does not speak on the bus; it has its own table, "
     "[camera]"},
    {"NoMessage", can("[can.signals]\nyaw_rate = { signal = \"S\" }\n"),
     "car.toml:4: [can.signals] yaw_rate message: is missing"},
    {"NoSignal", signal("yaw_rate", R"(, unit = "rad/s")"),
     R"(car.toml:4: [can.signals] yaw_rate: names no signal; add signal = "...")"},
    {"SignalAndSum", signal("yaw_rate", R"(, signal = "S", sum = ["A", "B"])"),
     "car.toml:4: [can.signals] yaw_rate: has both `signal` and `sum`; keep one"},
    {"NoUnit", signal("yaw_rate", R"(, signal = "S")"),
     R"(car.toml:4: [can.signals] yaw_rate unit: is missing; it is one of "rad/s", "deg/s")"},
    {"UnknownUnit", signal("yaw_rate", R"(, signal = "S", unit = "rad/")"),
     R"(car.toml:4: [can.signals] yaw_rate unit: "rad/" is not known; did you mean "rad"?)"},
    {"UnitOfAnotherRole", signal("yaw_rate", R"(, signal = "S", unit = "m/s")"),
     R"(car.toml:4: [can.signals] yaw_rate unit: "m/s" does not fit this role; it is one of )"
     R"("rad/s", "deg/s")"},
    {"RpmWithoutRadius", signal("motor", R"(, signal = "S", unit = "rpm")"),
     R"(car.toml:4: [can.signals] motor unit: "rpm" needs `radius`, the rolling radius of the )"
     "wheel "
     "in metres"},
    {"NegativeRadius", signal("motor", R"(, signal = "S", unit = "rpm", radius = -1)"),
     "car.toml:4: [can.signals] motor radius: -1 is not possible; it must be between 0 and 10 (m)"},
    {"RadiusWithoutRpm", signal("motor", R"(, signal = "S", unit = "m/s", radius = 1)"),
     R"(car.toml:4: [can.signals] motor radius: goes with unit = "rpm" alone)"},
    {"PureNumberWithoutScale", signal("steering", R"(, signal = "S", unit = "1")"),
     R"(car.toml:4: [can.signals] steering unit: "1" needs `scale`, which turns the number into )"
     "the "
     "role's SI quantity"},
    {"ScaleOfZero", signal("motor", R"(, signal = "S", unit = "m/s", scale = 0)"),
     "car.toml:4: [can.signals] motor scale: 0 is not possible: the value would vanish"},
    {"SigmaOfZero", signal("motor", R"(, signal = "S", unit = "m/s", sigma = 0)"),
     "car.toml:4: [can.signals] motor sigma: 0 is not possible; it must be greater than 0"},
    {"NegativeLatency", signal("motor", R"(, signal = "S", unit = "m/s", latency = -0.1)"),
     "car.toml:4: [can.signals] motor latency: -0.1 is not possible; it must be between 0 and 1 "
     "(s)"},
    {"TimeoutOfZero", signal("motor", R"(, signal = "S", unit = "m/s", timeout = 0)"),
     "car.toml:4: [can.signals] motor timeout: 0 is not possible; it must be between 0 and 60 (s)"},
    {"UnknownSignalKey", signal("motor", R"(, signal = "S", unit = "m/s", scal = 2)"),
     R"(car.toml:4: [can.signals] motor scal: unknown key; did you mean "scale"?)"},
    {"ValidWhenWithoutSignal",
     signal("motor", R"(, signal = "S", unit = "m/s", valid_when = { equals = 0 })"),
     "car.toml:4: [can.signals] motor valid_when signal: is missing"},
    {"ValidWhenIsNoTable", signal("motor", R"(, signal = "S", unit = "m/s", valid_when = 1)"),
     "car.toml:4: [can.signals] motor valid_when: is a number; it must be a table"},
    {"ForwardOfASpeed", signal("motor", R"(, signal = "S", unit = "m/s", forward = 1)"),
     "car.toml:4: [can.signals] motor forward: belongs to the role direction"},
    {"DirectionWithoutReverse", signal("direction", R"(, signal = "S", forward = 1)"),
     "car.toml:4: [can.signals] direction reverse: is missing"},
    {"DirectionWithoutADifference",
     signal("direction", R"(, signal = "S", forward = 1, reverse = 1)"),
     "car.toml:4: [can.signals] direction reverse: is the same value as forward"},
    {"DirectionWithUnit",
     signal("direction", R"(, signal = "S", forward = 1, reverse = 2, unit = "m/s")"),
     "car.toml:4: [can.signals] direction unit: does not apply to a direction"},
    {"DirectionAsSum", signal("direction", R"(, sum = ["A", "B"], forward = 1, reverse = 2)"),
     "car.toml:4: [can.signals] direction sum: a direction is one signal"},
    {"SignalIsNoTable", can("[can.signals]\nmotor = \"N\"\n"),
     "car.toml:4: [can.signals] motor: is a text; it must be a table"},

    {"NoProfile", e2e(R"(crc = "C")"),
     "car.toml:4: [can.e2e] M profile: is missing; it is one of none, P01, P02, P11, P22, COUNTER, "
     "SAE_J1850"},
    {"MisspeltProfile", e2e(R"(profil = "P01")"),
     R"(car.toml:4: [can.e2e] M profil: unknown key; did you mean "profile"?)"},
    {"UnknownProfile", e2e(R"(profile = "P07")"),
     R"(car.toml:4: [can.e2e] M profile: "P07" is not known; did you mean "P01"?)"},
    {"NoDataId", e2e(R"(profile = "P01", crc = "C", counter = "B")"),
     "car.toml:4: [can.e2e] M data_id: is missing"},
    {"DataIdTooLarge", e2e(R"(profile = "P01", data_id = 65536, crc = "C", counter = "B")"),
     "car.toml:4: [can.e2e] M data_id: 65536 is not possible; it must be 0 to 65535"},
    {"NoCrc", e2e(R"(profile = "P01", data_id = 1, counter = "B")"),
     "car.toml:4: [can.e2e] M crc: is missing"},
    {"NoCounter", e2e(R"(profile = "COUNTER")"), "car.toml:4: [can.e2e] M counter: is missing"},
    {"ShortDataIdList", e2e(R"(profile = "P02", data_id_list = [1], crc = "C", counter = "B")"),
     "car.toml:4: [can.e2e] M data_id_list: must be a list of 16 whole numbers"},
    {"UnknownDataIdMode",
     e2e(R"(profile = "P01", data_id = 1, crc = "C", counter = "B", )"
         R"(data_id_mode = "BOT")"),
     R"(car.toml:4: [can.e2e] M data_id_mode: "BOT" is not known; did you mean "BOTH"?)"},
    {"DataIdOfAnotherProfile", e2e(R"(profile = "COUNTER", counter = "B", data_id = 1)"),
     "car.toml:4: [can.e2e] M data_id: belongs to P01 and P11, not to COUNTER; leave it out, or "
     "mend the profile"},
    {"CrcOfAnotherProfile", e2e(R"(profile = "COUNTER", counter = "B", crc = "C")"),
     "car.toml:4: [can.e2e] M crc: belongs to the profiles with a CRC, not to COUNTER; leave it "
     "out, or mend the profile"},
    {"DataIdListOfAnotherProfile",
     e2e(R"(profile = "P01", data_id = 1, crc = "C", counter = "B", data_id_list = [1])"),
     "car.toml:4: [can.e2e] M data_id_list: belongs to P02 and P22, not to P01; leave it out, or "
     "mend the profile"},
    {"StepOfACounterThatIsNotThere",
     e2e(R"(profile = "SAE_J1850", crc = "C", max_delta_counter = 2)"),
     "car.toml:4: [can.e2e] M max_delta_counter: belongs to messages with a `counter`, not to "
     "SAE_J1850; leave it out, or mend the profile"},

    {"UnknownModel", also("[filter]\nmodel = \"particle\"\n"),
     R"(car.toml:3: [filter] model: "particle" is not a model of this version; there are: kinematic, )"
     "kinematic_printed, paper, full"},
    {"ShortNoise", also("[filter]\npaper_q = [1, 2]\n"),
     "car.toml:3: [filter] paper_q: must be a list of 3 numbers"},
    {"NegativeNoise", also("[filter]\npaper_r = [1, -2]\n"),
     "car.toml:3: [filter] paper_r: -2 is not possible; it must be greater than 0"},
    {"WindowTooShort", also("[filter]\nwindow = 0.1\n"),
     "car.toml:3: [filter] window: 0.1 is not possible; it must be 0.2 to 1 (s)"},
    {"WindowTooLong", also("[filter]\nwindow = 1.5\n"),
     "car.toml:3: [filter] window: 1.5 is not possible; it must be 0.2 to 1 (s)"},
    {"CameraGateThatLetsNothingIn", also("[filter]\ncamera_gate = 0\n"),
     "car.toml:3: [filter] camera_gate: 0 is not possible; it must be 1 to 1e6"},
    {"WalkThatStandsStill", also("[filter]\ngyro_bias_walk = 0\n"),
     "car.toml:3: [filter] gyro_bias_walk: 0 is not possible; it must be above 0, at most 1"},
    {"MountingInDegrees", also("[imu]\nyaw = 90\n"),
     "car.toml:3: [imu] yaw: 90 is not possible; it must be -3.15 to 3.15 (rad)"},
    {"NoPose", also("[initial]\n"), "car.toml:2: [initial] pose: is missing"},
    {"ShortPose", also("[initial]\npose = [0, 0]\n"),
     "car.toml:3: [initial] pose: must be a list of 3 numbers"},
    {"TextInPose", also("[initial]\npose = [0, 0, \"north\"]\n"),
     "car.toml:3: [initial] pose: is a text; it must be a number"},
    {"PeriodOfZero", also("[realtime]\nperiod = 0\n"),
     "car.toml:3: [realtime] period: 0 is not possible; it must be 0.001 to 0.1 (s)"},
    {"NegativePeriod", also("[realtime]\nperiod = -0.005\n"),
     "car.toml:3: [realtime] period: -0.005 is not possible; it must be 0.001 to 0.1 (s)"},
    {"PriorityTooHigh", also("[realtime]\npriority = 100\n"),
     "car.toml:3: [realtime] priority: 100 is not possible; it must be 2 to 99"},
    {"CpuTooLow", also("[realtime]\ncpu = -2\n"),
     "car.toml:3: [realtime] cpu: -2 is not possible; it must be -1 to 1023"},
    {"ShmNameWithoutSlash", also("[shm]\nname = \"odomd\"\n"),
     R"(car.toml:3: [shm] name: must begin with a slash: "/odomd", or a path)"},
    {"ModeThatIsNone", also("[shm]\nmode = \"rw\"\n"),
     "car.toml:3: [shm] mode: is not a file mode; write it as 0o660"},
    {"ModeThatLetsOthersWrite", also("[shm]\nmode = 0o660\n"),
     "car.toml:3: [shm] mode: must be 0o600, 0o640 or 0o644: clients refuse what others may write"},
    {"CameraLatency", also("[camera]\nmax_latency = 0\n"),
     "car.toml:3: [camera] max_latency: 0 is not possible; it must be between 0 and 10 (s)"},
    {"EmptySocket", also("[camera]\nsocket = \"\"\n"),
     "car.toml:3: [camera] socket: is empty; it must name a file"},
    {"UnknownLevel", also("[log]\nlevel = \"warning\"\n"),
     R"(car.toml:3: [log] level: "warning" is not known; did you mean "warn"?)"},
    {"ControlCharacter", also("[shm]\nname = \"/a\\nb\"\n"),
     "car.toml:3: [shm] name: holds a control character"},
};

INSTANTIATE_TEST_SUITE_P(All, ConfigMistake, testing::ValuesIn(mistakes),
                         [](const auto& test) { return std::string(test.param.name); });

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
}  // namespace odomd::daemon
