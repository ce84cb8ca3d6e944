// The errors of invalid configurations. Every error is compared as a whole, because it is all that
// the user gets.
#include <filesystem>

#include "config_files.hpp"
#include "tests/table.hpp"

namespace odomd::daemon::config_mistakes_test {
namespace {

// Files that are not a configuration

TEST_F(ConfigTest, RefusesFilesThatAreNotConfigurations) {
  EXPECT_EQ(error(), "car.toml: cannot be read: No such file or directory; check the path");
  EXPECT_EQ(error_of(std::string("[vehicle]\nmass\0 = 3\n", 20)),
            "car.toml:2: holds a NUL byte; the file is damaged or not a text");
  EXPECT_EQ(error_of(""),
            "car.toml:1: can: is missing; name the database and the signals in [can]");
  EXPECT_EQ(error_of(std::string((1 << 20) + 1, '\n')),
            "car.toml: is larger than 1 MiB; is this the configuration?");
  std::filesystem::remove(file_);
  std::filesystem::create_directory(file_);
  EXPECT_EQ(error(), "car.toml: is a directory; name a file");
}

TEST_F(ConfigTest, RefusesInvalidToml) {
  EXPECT_THAT(error_of("[vehicle]\nmass = = 3\n"), StartsWith("car.toml:2: not TOML: "));
  EXPECT_THAT(error_of("a = \"\xff\xfe\"\n"), StartsWith("car.toml:1: not TOML: "));
  EXPECT_THAT(error_of("[vehicle\nx"), StartsWith("car.toml:1: not TOML: "));
  EXPECT_THAT(error_of("a = 1\na = 2\n"), StartsWith("car.toml:2: not TOML: "));
}

TEST_F(ConfigTest, RefusesDeepNesting) {
  std::string key = "a", tables = "\n";
  for (int i = 0; i < 50000; ++i) key += ".a", tables += "b={";
  for (const std::string& text : {key + " = 1", '[' + key + ']', "b = [1.5, {" + key + " = 1}]"})
    EXPECT_EQ(error_of('\n' + text + '\n'),
              "car.toml:2: has more than 200 dots; write the tables that a key means");
  for (const std::string& text : {"\nb = " + std::string(50000, '['), tables})
    EXPECT_THAT(error_of(text), StartsWith("car.toml:2: not TOML: "));
}

// All other errors, one line each

class ConfigMistakes : public ConfigTest {
 protected:
  /// For each row of the table: the mistake is put between `before` and `after`, and its error must
  /// follow `place`.
  void expect(const std::string& before, const std::string& after, const std::string& place,
              const char* table) const {
    for_each_row(table, [&](const std::string& mistake, const std::string& error) {
      EXPECT_EQ(error_of(before + mistake + after), place + error) << mistake;
    });
  }
};

const std::string can = "[can]\ndbc = \"car.dbc\"\n";

TEST_F(ConfigMistakes, InTheWholeFileAreNamedWithTheirLineAndFix) {
  expect("", "\n", "car.toml:", R"(
vehicle = 3 -> 1: vehicle: is a number; it must be a table
[can]¶source = "can0" -> 1: [can] dbc: is missing; name the car's database
[can]¶dbcs = "car.dbc" -> 2: [can] dbcs: unknown key; did you mean "dbc"?
[cam] -> 1: cam: unknown key; did you mean "can"?
[can]¶dbc = "car.dbc" -> 1: [can] signals: is missing; name the signal of each role in [can.signals]
)");
}

TEST_F(ConfigMistakes, InTheCarAreNamedWithTheirLineAndFix) {
  expect("[vehicle]\n", small_bus, "car.toml:", R"(
mas = 3 -> 2: [vehicle] mas: unknown key; did you mean "mass"?
mass = 2,985 -> 2: not TOML: Error while parsing key-value pair: expected a comment or whitespace, saw ','; mass:
  write a number with a decimal point: 2.5, not 2,5
mass = 0 -> 2: [vehicle] mass: 0 is not possible; it must be greater than 0
mass = nan -> 2: [vehicle] mass: nan is not possible; it must be a finite number, greater than 0
mass = inf -> 2: [vehicle] mass: inf is not possible; it must be a finite number, greater than 0
mass = "3" -> 2: [vehicle] mass: is a text; it must be a number
mass = true -> 2: [vehicle] mass: is true or false; it must be a number
mass = 3 -> 1: [vehicle] front_axle: is missing; give all keys of [vehicle], or leave the table out
mass = -9223372036854775807 -> 2: [vehicle] mass: -9.223372036854776e+18 is not possible; it must be greater than 0
mass = 1e400 -> 2: not TOML: Error while parsing floating-point: '1e400' could not be interpreted as a value; a
  number is at most 1.8e308 in size
grip_front = 0 -> 2: [vehicle] grip_front: 0 is not possible; it must be greater than 0
)");
}

TEST_F(ConfigMistakes, OfTheBusAreNamedWithTheirLineAndFix) {
  expect(can, "\n", "car.toml:", R"(
[can.signalz] -> 3: [can] signalz: unknown key; did you mean "signals"?
[can.signals] -> 3: [can.signals]: is empty; map at least a wheel speed
source = "" -> 3: [can] source: holds an empty name
source = [] -> 3: [can] source: is an empty list
source = [1] -> 3: [can] source: is a number; it must be a text in quotes
source = ["1", "2", "3", "4", "5", "6", "7", "8", "9"] -> 3: [can] source: names 9 buses; at most 8 are allowed
source = ["can0", "can0"] -> 3: [can] source: names "can0" twice; leave one of them out
timestamps = "hardwear" -> 3: [can] timestamps: "hardwear" is not known; did you mean "hardware"?
receive_buffer = 10 -> 3: [can] receive_buffer: 10 is not possible; it must be 4096 to 1073741824
receive_buffer = 5000.5 -> 3: [can] receive_buffer: 5000.5 is not possible; it must be a whole number, 4096 to
  1073741824, without a point or an exponent
receive_buffer = 1e4 -> 3: [can] receive_buffer: 10000 is not possible; it must be a whole number, 4096 to
  1073741824, without a point or an exponent
receive_buffer = "8192" -> 3: [can] receive_buffer: is a text; it must be a whole number, 4096 to 1073741824
)");
}

TEST_F(ConfigMistakes, OfSignalsAreNamedWithTheirLineAndFix) {
  const std::string signals = can + "[can.signals]\n", place = "car.toml:4: [can.signals] ";
  expect(signals, "\n", place, R"(
yaw_rat = {} -> yaw_rat: unknown role; did you mean "yaw_rate"?
camera = {} -> camera: the camera is not on the bus; configure it in its own table, [camera]
motor = "N" -> motor: is a text; it must be a table
yaw_rate = { signal = "S" } -> yaw_rate message: is missing
yaw_rate = { message = "M", unit = "rad/s" } -> yaw_rate: names no signal; add signal = "..."
yaw_rate = { message = "M", signal = "S", sum = ["A", "B"] } -> yaw_rate: has both `signal` and `sum`; keep one
yaw_rate = { message = "M", signal = "S" } -> yaw_rate unit: is missing; it is one of "rad/s", "deg/s"
)");
  expect(signals + "yaw_rate = { message = \"M\", signal = \"S\", ", " }\n", place + "yaw_rate ",
         R"(
unit = "rad/" -> unit: "rad/" is not known; it is one of "rad/s", "deg/s"
unit = "m/s" -> unit: "m/s" does not fit this role; it is one of "rad/s", "deg/s"
unit = "1" -> unit: "1" needs `scale`, which turns the number into the role's SI quantity
unit = "%" -> unit: "%" needs `scale`, which turns the number into the role's SI quantity
unit = "rad/s", dead_band = 0.1 -> dead_band: applies only to wheels and motor; leave it out
)");
  expect(signals + "motor = { message = \"M\", signal = \"S\", ", " }\n", place + "motor ", R"(
unit = "rpm" -> unit: "rpm" needs `radius`, the rolling radius of the wheel in metres
unit = "rpm", radius = -1 -> radius: -1 is not possible; it must be between 0 and 10 (m)
unit = "erpm", radius = 0.03 -> unit: "erpm" needs `pole_pairs`, the pole pairs of the motor
)");
  expect(signals + "motor = { message = \"M\", signal = \"S\", unit = \"m/s\", ", " }\n",
         place + "motor ", R"(
radius = 1 -> radius: applies only to wheels and motor with unit = "rpm", "erpm", "rad/s" or "deg/s"
scale = 0 -> scale: must not be 0
sigma = 0 -> sigma: 0 is not possible; it must be greater than 0
latency = -0.1 -> latency: -0.1 is not possible; it must be between 0 and 1 (s)
timeout = 0 -> timeout: 0 is not possible; it must be between 0 and 60 (s)
dead_band = 3.1 -> dead_band: 3.1 is not possible; it must be between 0 and 3 (m/s)
dead_band = -0.1 -> dead_band: -0.1 is not possible; it must be between 0 and 3 (m/s)
scal = 2 -> scal: unknown key; did you mean "scale"?
valid_when = { equals = 0 } -> valid_when signal: is missing
valid_when = 1 -> valid_when: is a number; it must be a table
valid_when = [1] -> valid_when: holds a number; it must hold tables
valid_when = [{ signal = "V" }] -> valid_when: needs one of equals, not_equals, below, at_least
valid_when = { signal = "V", below = 1, equals = 0 } -> valid_when: needs one of equals, not_equals, below, at_least
unless_raw = 1 -> unless_raw: is a number; it must be a list of whole numbers
unless_raw = [0.5] -> unless_raw: must hold whole numbers
unless_raw = "all" -> unless_raw: "all" is not known; did you mean "max"?
sign = { signal = "V" } -> sign negative: is missing
source = 256 -> source: 256 is not possible; it must be 0 to 255
forward = 1 -> forward: belongs to the role direction
)");
  expect(signals + "direction = { message = \"M\", forward = 1, ", " }\n", place + "direction ", R"(
signal = "S" -> reverse: is missing
signal = "S", reverse = 1 -> reverse: is the same value as forward
signal = "S", reverse = 2, dead_band = 0.1 -> dead_band: applies only to wheels and motor; leave it out
signal = "S", reverse = 2, sign = { signal = "V", negative = 1 } -> sign: does not apply to a direction
signal = "S", reverse = 2, unit = "m/s" -> unit: does not apply to a direction
sum = ["A", "B"], reverse = 2 -> sum: a direction is taken from one signal
)");
}

TEST_F(ConfigMistakes, OfProtectionsAreNamedWithTheirLineAndFix) {
  expect(can + "[can.e2e]\nM = { ", " }\n", "car.toml:4: [can.e2e] M ", R"(
crc = "C" -> profile: is missing; it is one of none, P01, P02, P11, P22, COUNTER, SAE_J1850
profil = "P01" -> profil: unknown key; did you mean "profile"?
profile = "P07" -> profile: "P07" is not known; did you mean "P01"?
profile = "P01", crc = "C", counter = "B" -> data_id: is missing
profile = "P01", data_id = 65536, crc = "C", counter = "B" -> data_id: 65536 is not possible; it must be 0 to 65535
profile = "P01", data_id = 1, counter = "B" -> crc: is missing
profile = "COUNTER" -> counter: is missing
profile = "P02", data_id_list = [1], crc = "C", counter = "B" -> data_id_list: must be a list of 16 whole numbers
profile = "P01", data_id = 1, crc = "C", counter = "B", data_id_mode = "BOT" -> data_id_mode: "BOT" is not known;
  did you mean "BOTH"?
profile = "COUNTER", counter = "B", data_id = 1 -> data_id: belongs to P01 and P11, not to COUNTER; leave it out, or
  fix the profile
profile = "COUNTER", counter = "B", crc = "C" -> crc: belongs to the profiles with a CRC, not to COUNTER; leave it
  out, or fix the profile
profile = "P01", data_id = 1, crc = "C", counter = "B", data_id_list = [1] -> data_id_list: belongs to P02 and P22,
  not to P01; leave it out, or fix the profile
profile = "SAE_J1850", crc = "C", max_delta_counter = 2 -> max_delta_counter: belongs to messages with a `counter`,
  not to SAE_J1850; leave it out, or fix the profile
)");
}

TEST_F(ConfigMistakes, OfOtherTablesAreNamedWithTheirLineAndFix) {
  expect("# 1\n", small_bus, "car.toml:", R"(
[vehicel] -> 2: vehicel: unknown key; did you mean "vehicle"?
[initial]¶pose = [0, 0, 0]¶qqqqqqqqq = 1 -> 4: [initial] qqqqqqqqq: unknown key; did you mean "pose"?
[imu]¶position = [0,04, 0,015] -> 3: not TOML: Error while parsing decimal integer: leading zeroes are prohibited;
  position: write a number with a decimal point: 2.5, not 2,5
[filter]¶model = "particle" -> 3: [filter] model: "particle" is not a model of this version; the models are:
  kinematic, kinematic_printed, paper, full, inertial
[filter]¶paper_q = [1, 2] -> 3: [filter] paper_q: must be a list of 3 numbers
[filter]¶paper_r = [1, -2] -> 3: [filter] paper_r: -2 is not possible; it must be greater than 0
[filter]¶window = 0.1 -> 3: [filter] window: 0.1 is not possible; it must be 0.2 to 1 (s)
[filter]¶window = 1.5 -> 3: [filter] window: 1.5 is not possible; it must be 0.2 to 1 (s)
[filter]¶camera_gate = 0 -> 3: [filter] camera_gate: 0 is not possible; it must be 1 to 1e6
[filter]¶gyro_bias_walk = 0 -> 3: [filter] gyro_bias_walk: 0 is not possible; it must be 1e-9 to 1
[filter]¶yaw_momnt_error = 7 -> 3: [filter] yaw_momnt_error: unknown key; did you mean "side_slip_error"?
[filter]¶front_angle_error = 10 -> 3: [filter] front_angle_error: 10 is not possible; it must be 1e-9 to 1
[filter]¶side_slip_error = 0 -> 3: [filter] side_slip_error: 0 is not possible; it must be 1e-9 to 10
[filter]¶wheel_slip = 1e-200 -> 3: [filter] wheel_slip: 1e-200 is not possible; it must be 1e-9 to 1
[steering]¶delay = 60 -> 3: [steering] delay: 60 is not possible; it must be 0 to 0.5 (s)
[steering]¶lag = 100 -> 3: [steering] lag: 100 is not possible; it must be 0 to 1 (s)
[steering]¶rate_limit = 0 -> 3: [steering] rate_limit: 0 is not possible; it must be greater than 0
[imu]¶roll_gradient = 7 -> 3: [imu] roll_gradient: 7 is not possible; it must be -0.5 to 0.5 (rad per g)
[imu]¶yaw = 90 -> 3: [imu] yaw: 90 is not possible; it must be -3.15 to 3.15 (rad)
[initial] -> 2: [initial] pose: is missing
[initial]¶pose = [0, 0] -> 3: [initial] pose: must be a list of 3 numbers
[initial]¶pose = [0, 0, 1e17] -> 3: [initial] pose: is too far away; x and y must be within 1e8 m, yaw within 1e6
  rad
[initial]¶pose = [0, 0, "north"] -> 3: [initial] pose: is a text; it must be a number
[realtime]¶period = 0 -> 3: [realtime] period: 0 is not possible; it must be 0.001 to 0.1 (s)
[realtime]¶priority = 100 -> 3: [realtime] priority: 100 is not possible; it must be 2 to 99
[realtime]¶cpu = -2 -> 3: [realtime] cpu: -2 is not possible; it must be -1 to 1023
[shm]¶name = "odomd" -> 3: [shm] name: must begin with a slash: "/odomd", or a path
[shm]¶mode = "rw" -> 3: [shm] mode: is not a file mode; write it as 0o660
[shm]¶mode = 0o660 -> 3: [shm] mode: must be 0o600, 0o640 or 0o644: clients refuse what others may write
[camera]¶max_latency = 0 -> 3: [camera] max_latency: 0 is not possible; it must be between 0 and 10 (s)
[reference]¶lever_arm = [0.1, 0] -> 3: [reference] lever_arm: must be a list of 3 numbers
[camera]¶socket = "" -> 3: [camera] socket: is empty; it must name a file
[log]¶level = "warning" -> 3: [log] level: "warning" is not known; did you mean "warn"?
[shm]¶name = "/a\nb" -> 3: [shm] name: holds a control character
)");
}

}  // namespace
}  // namespace odomd::daemon::config_mistakes_test
