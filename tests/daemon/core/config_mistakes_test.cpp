// The errors of invalid configurations. Every error is compared as a whole, because it is all that
// the user gets.
#include <filesystem>

#include "config_files.hpp"

namespace odomd::daemon::config_mistakes_test {
namespace {

// Files that are not a configuration
// ------------------------------------------------------------------

TEST_F(ConfigTest, RefusesAFileThatIsNotThere) {
  EXPECT_EQ(error(), "car.toml: cannot be read: No such file or directory; check the path");
}

TEST_F(ConfigTest, RefusesADirectory) {
  std::filesystem::create_directory(file_);
  EXPECT_EQ(error(), "car.toml: is a directory; name a file");
}

TEST_F(ConfigTest, RefusesWhatIsNotToml) {
  EXPECT_THAT(error_of("[vehicle]\nmass = = 3\n"), testing::StartsWith("car.toml:2: not TOML: "));
  EXPECT_THAT(error_of("a = \"\xff\xfe\"\n"), testing::StartsWith("car.toml:1: not TOML: "));
  EXPECT_THAT(error_of("[vehicle\nx"), testing::StartsWith("car.toml:1: not TOML: "));
  EXPECT_THAT(error_of("a = 1\na = 2\n"), testing::StartsWith("car.toml:2: not TOML: "));
}

TEST_F(ConfigTest, RefusesWhatIsNestedTooDeep) {
  const auto dotted = [](int parts) {
    std::string key = "a";
    for (int i = 1; i < parts; ++i) key += ".a";
    return key;
  };
  const char* const too_many = "car.toml:2: more than 16 brackets are open; close those before";
  const char* const too_long =
      "car.toml:2: a key of more than 16 parts; write the tables that it means";
  EXPECT_EQ(error_of("\n" + dotted(50000) + " = 1\n"), too_long);
  EXPECT_EQ(error_of("\n[" + dotted(50000) + "]\n"), too_long);
  EXPECT_EQ(error_of("\nb = [1.5, {" + dotted(17) + " = 1}]\n"), too_long);
  EXPECT_EQ(error_of("\nb = " + std::string(50000, '[')), too_many);
  EXPECT_EQ(error_of("\nb = " + std::string(17, '[') + std::string(17, ']') + "\n"), too_many);
  std::string tables = "\n";
  for (int i = 0; i < 50000; ++i) tables += "b={";
  EXPECT_EQ(error_of(tables), too_many);
}

TEST_F(ConfigTest, CountsNoDotsAndBracketsOfTextsAndComments) {
  const std::string deep = std::string(40, '.') + std::string(40, '[');
  for (const std::string& text : {R"("\")" + deep + '"', "'" + deep + "'",
                                  "\"\"\"\n" + deep + "\"\n\"\"\"\"", "'''\n" + deep + "''\n'''"})
    EXPECT_THAT(error_of("x = " + text + "  # " + deep + "\n[[[[["),
                testing::HasSubstr(": not TOML: "))
        << text;
  EXPECT_THAT(error_of("x = \"" + deep + "\n"), testing::StartsWith("car.toml:1: not TOML: "));
}

TEST_F(ConfigTest, RefusesNulBytes) {
  EXPECT_EQ(error_of(std::string("[vehicle]\nmass\0 = 3\n", 20)),
            "car.toml:2: holds a NUL byte; the file is damaged or not a text");
}

TEST_F(ConfigTest, RefusesAnEmptyFile) {
  EXPECT_EQ(error_of(""),
            "car.toml:1: can: is missing; name the database and the signals in [can]");
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

TEST_P(ConfigMistake, IsNamedWithItsLineAndFix) {
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
    {"DecimalComma", vehicle("mass = 2,985"),
     "car.toml:2: not TOML: Error while parsing key-value pair: expected a comment or whitespace, "
     "saw ','; mass: write a number with a decimal point: 2.5, not 2,5"},
    {"DecimalCommaInAnArray", also("[imu]\nposition = [0,04, 0,015]\n"),
     "car.toml:3: not TOML: Error while parsing decimal integer: leading zeroes are prohibited; "
     "position: write a number with a decimal point: 2.5, not 2,5"},
    {"ZeroMass", vehicle("mass = 0"),
     "car.toml:2: [vehicle] mass: 0 is not possible; it must be greater than 0"},
    {"NanMass", vehicle("mass = nan"),
     "car.toml:2: [vehicle] mass: nan is not possible; it must be a finite number, greater than 0"},
    {"InfiniteMass", vehicle("mass = inf"),
     "car.toml:2: [vehicle] mass: inf is not possible; it must be a finite number, greater than 0"},
    {"TextForANumber", vehicle(R"(mass = "3")"),
     "car.toml:2: [vehicle] mass: is a text; it must be a number"},
    {"BooleanForANumber", vehicle("mass = true"),
     "car.toml:2: [vehicle] mass: is true or false; it must be a number"},
    {"HalfACar", vehicle("mass = 3"),
     "car.toml:1: [vehicle] front_axle: is missing; give all keys of [vehicle], or leave the table "
     "out"},

    {"NoDatabase", "[can]\nsource = \"can0\"\n",
     "car.toml:1: [can] dbc: is missing; name the car's database"},
    {"MisspeltDatabase", "[can]\ndbcs = \"car.dbc\"\n",
     R"(car.toml:2: [can] dbcs: unknown key; did you mean "dbc"?)"},
    {"MisspeltSignals", can("[can.signalz]\n"),
     R"(car.toml:3: [can] signalz: unknown key; did you mean "signals"?)"},
    {"MisspeltCan", "[cam]\n", R"(car.toml:1: cam: unknown key; did you mean "can"?)"},
    {"NoSignals", can(""),
     "car.toml:1: [can] signals: is missing; name the signal of each role in [can.signals]"},
    {"EmptySignals", can("[can.signals]\n"),
     "car.toml:3: [can.signals]: is empty; map at least a wheel speed"},
    {"EmptySource", can("source = \"\"\n"), "car.toml:3: [can] source: holds an empty name"},
    {"NoSourceInList", can("source = []\n"), "car.toml:3: [can] source: is an empty list"},
    {"NumberAsSource", can("source = [1]\n"),
     "car.toml:3: [can] source: is a number; it must be a text in quotes"},
    {"TooManySources",
     can("source = [\"1\", \"2\", \"3\", \"4\", \"5\", \"6\", \"7\", \"8\", \"9\"]\n"),
     "car.toml:3: [can] source: names 9 buses; at most 8 are allowed"},
    {"SourceTwice", can("source = [\"can0\", \"can0\"]\n"),
     "car.toml:3: [can] source: names \"can0\" twice; leave one of them out"},
    {"UnknownTimestamps", can("timestamps = \"hardwear\"\n"),
     R"(car.toml:3: [can] timestamps: "hardwear" is not known; did you mean "hardware"?)"},
    {"TinyReceiveBuffer", can("receive_buffer = 10\n"),
     "car.toml:3: [can] receive_buffer: 10 is not possible; it must be 4096 to 1073741824"},
    {"FractionForAWhole", can("receive_buffer = 5000.5\n"),
     "car.toml:3: [can] receive_buffer: 5000.5 is not possible; it must be a whole number, 4096 to "
     "1073741824, without a point or an exponent"},
    {"ExponentForAWhole", can("receive_buffer = 1e4\n"),
     "car.toml:3: [can] receive_buffer: 10000 is not possible; it must be a whole number, 4096 to "
     "1073741824, without a point or an exponent"},
    {"TextForAWhole", can("receive_buffer = \"8192\"\n"),
     "car.toml:3: [can] receive_buffer: is a text; it must be a whole number, 4096 to 1073741824"},
    {"HugeWholeNumber", vehicle("mass = -9223372036854775807"),
     "car.toml:2: [vehicle] mass: -9.223372036854776e+18 is not possible; it must be greater than "
     "0"},
    {"HugeExponent", vehicle("mass = 1e400"),
     "car.toml:2: not TOML: Error while parsing floating-point: '1e400' could not be interpreted "
     "as a value; a number is at most 1.8e308 in size"},

    {"UnknownRole", signal("yaw_rat", R"(, signal = "S", unit = "rad/s")"),
     R"(car.toml:4: [can.signals] yaw_rat: unknown role; did you mean "yaw_rate"?)"},
    {"CameraIsNoSignal", signal("camera", R"(, signal = "S", unit = "rad/s")"),
     "car.toml:4: [can.signals] camera: the camera is not on the bus; configure it in its own "
     "table, [camera]"},
    {"NoMessage", can("[can.signals]\nyaw_rate = { signal = \"S\" }\n"),
     "car.toml:4: [can.signals] yaw_rate message: is missing"},
    {"NoSignal", signal("yaw_rate", R"(, unit = "rad/s")"),
     R"(car.toml:4: [can.signals] yaw_rate: names no signal; add signal = "...")"},
    {"SignalAndSum", signal("yaw_rate", R"(, signal = "S", sum = ["A", "B"])"),
     "car.toml:4: [can.signals] yaw_rate: has both `signal` and `sum`; keep one"},
    {"NoUnit", signal("yaw_rate", R"(, signal = "S")"),
     R"(car.toml:4: [can.signals] yaw_rate unit: is missing; it is one of "rad/s", "deg/s")"},
    {"UnknownUnit", signal("yaw_rate", R"(, signal = "S", unit = "rad/")"),
     R"(car.toml:4: [can.signals] yaw_rate unit: "rad/" is not known; it is one of "rad/s", "deg/s")"},
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
     R"(car.toml:4: [can.signals] motor radius: applies only to wheels and motor with unit = )"
     R"("rpm", "erpm", "rad/s" or "deg/s")"},
    {"PureNumberWithoutScale", signal("steering", R"(, signal = "S", unit = "1")"),
     R"(car.toml:4: [can.signals] steering unit: "1" needs `scale`, which turns the number into )"
     "the "
     "role's SI quantity"},
    {"ScaleOfZero", signal("motor", R"(, signal = "S", unit = "m/s", scale = 0)"),
     "car.toml:4: [can.signals] motor scale: must not be 0"},
    {"SigmaOfZero", signal("motor", R"(, signal = "S", unit = "m/s", sigma = 0)"),
     "car.toml:4: [can.signals] motor sigma: 0 is not possible; it must be greater than 0"},
    {"NegativeLatency", signal("motor", R"(, signal = "S", unit = "m/s", latency = -0.1)"),
     "car.toml:4: [can.signals] motor latency: -0.1 is not possible; it must be between 0 and 1 "
     "(s)"},
    {"TimeoutOfZero", signal("motor", R"(, signal = "S", unit = "m/s", timeout = 0)"),
     "car.toml:4: [can.signals] motor timeout: 0 is not possible; it must be between 0 and 60 (s)"},
    {"DeadBandTooWide", signal("motor", R"(, signal = "S", unit = "m/s", dead_band = 3.1)"),
     "car.toml:4: [can.signals] motor dead_band: 3.1 is not possible; it must be between 0 and 3 "
     "(m/s)"},
    {"NegativeDeadBand", signal("wheel_rear", R"(, signal = "S", unit = "m/s", dead_band = -0.1)"),
     "car.toml:4: [can.signals] wheel_rear dead_band: -0.1 is not possible; it must be between 0 "
     "and 3 (m/s)"},
    {"DeadBandOfAnAngle", signal("steering", R"(, signal = "S", unit = "rad", dead_band = 0.1)"),
     "car.toml:4: [can.signals] steering dead_band: applies only to wheels and motor; leave it "
     "out"},
    {"DeadBandOfADirection",
     signal("direction", R"(, signal = "S", forward = 1, reverse = 2, dead_band = 0.1)"),
     "car.toml:4: [can.signals] direction dead_band: applies only to wheels and motor; leave it "
     "out"},
    {"UnknownSignalKey", signal("motor", R"(, signal = "S", unit = "m/s", scal = 2)"),
     R"(car.toml:4: [can.signals] motor scal: unknown key; did you mean "scale"?)"},
    {"ValidWhenWithoutSignal",
     signal("motor", R"(, signal = "S", unit = "m/s", valid_when = { equals = 0 })"),
     "car.toml:4: [can.signals] motor valid_when signal: is missing"},
    {"ValidWhenIsNoTable", signal("motor", R"(, signal = "S", unit = "m/s", valid_when = 1)"),
     "car.toml:4: [can.signals] motor valid_when: is a number; it must be a table"},
    {"ValidWhenIsAListOfNumbers",
     signal("motor", R"(, signal = "S", unit = "m/s", valid_when = [1])"),
     "car.toml:4: [can.signals] motor valid_when: holds a number; it must hold tables"},
    {"ValidWhenWithoutComparison",
     signal("motor", R"(, signal = "S", unit = "m/s", valid_when = [{ signal = "V" }])"),
     "car.toml:4: [can.signals] motor valid_when: needs one of equals, not_equals, below, "
     "at_least"},
    {"ValidWhenWithTwoComparisons",
     signal(
         "motor",
         R"(, signal = "S", unit = "m/s", valid_when = { signal = "V", below = 1, equals = 0 })"),
     "car.toml:4: [can.signals] motor valid_when: needs one of equals, not_equals, below, "
     "at_least"},
    {"UnlessRawIsANumber", signal("motor", R"(, signal = "S", unit = "m/s", unless_raw = 1)"),
     "car.toml:4: [can.signals] motor unless_raw: is a number; it must be a list of whole numbers"},
    {"UnlessRawOfHalves", signal("motor", R"(, signal = "S", unit = "m/s", unless_raw = [0.5])"),
     "car.toml:4: [can.signals] motor unless_raw: must hold whole numbers"},
    {"UnlessRawMisspelt", signal("motor", R"(, signal = "S", unit = "m/s", unless_raw = "all")"),
     R"(car.toml:4: [can.signals] motor unless_raw: "all" is not known; did you mean "max"?)"},
    {"SignOfADirection",
     signal("direction",
            R"(, signal = "S", forward = 1, reverse = 2, sign = { signal = "V", negative = 1 })"),
     "car.toml:4: [can.signals] direction sign: does not apply to a direction"},
    {"SignWithoutNegative",
     signal("motor", R"(, signal = "S", unit = "m/s", sign = { signal = "V" })"),
     "car.toml:4: [can.signals] motor sign negative: is missing"},
    {"SourceOfNoByte", signal("motor", R"(, signal = "S", unit = "m/s", source = 256)"),
     "car.toml:4: [can.signals] motor source: 256 is not possible; it must be 0 to 255"},
    {"ErpmWithoutPolePairs", signal("motor", R"(, signal = "S", unit = "erpm", radius = 0.03)"),
     R"(car.toml:4: [can.signals] motor unit: "erpm" needs `pole_pairs`, the pole pairs of the motor)"},
    {"PercentWithoutScale", signal("steering", R"(, signal = "S", unit = "%")"),
     R"(car.toml:4: [can.signals] steering unit: "%" needs `scale`, which turns the number into )"
     "the role's SI quantity"},
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
     "car.toml:4: [can.signals] direction sum: a direction is taken from one signal"},
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
     "fix the profile"},
    {"CrcOfAnotherProfile", e2e(R"(profile = "COUNTER", counter = "B", crc = "C")"),
     "car.toml:4: [can.e2e] M crc: belongs to the profiles with a CRC, not to COUNTER; leave it "
     "out, or fix the profile"},
    {"DataIdListOfAnotherProfile",
     e2e(R"(profile = "P01", data_id = 1, crc = "C", counter = "B", data_id_list = [1])"),
     "car.toml:4: [can.e2e] M data_id_list: belongs to P02 and P22, not to P01; leave it out, or "
     "fix the profile"},
    {"StepOfACounterThatIsNotThere",
     e2e(R"(profile = "SAE_J1850", crc = "C", max_delta_counter = 2)"),
     "car.toml:4: [can.e2e] M max_delta_counter: belongs to messages with a `counter`, not to "
     "SAE_J1850; leave it out, or fix the profile"},

    {"UnknownModel", also("[filter]\nmodel = \"particle\"\n"),
     R"(car.toml:3: [filter] model: "particle" is not a model of this version; the models are: kinematic, )"
     "kinematic_printed, paper, full, inertial"},
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
    {"TyreForceErrorOfOld", also("[filter]\ntyre_force_error = 1\n"),
     "car.toml:3: [filter] tyre_force_error: was removed; use side_slip_error instead, the error "
     "of "
     "v_y per lateral acceleration"},
    {"YawMomentErrorOfOld", also("[filter]\nyaw_moment_error = 7\n"),
     "car.toml:3: [filter] yaw_moment_error: was removed; use front_angle_error instead, an angle "
     "at "
     "the front wheels in rad"},
    {"NoSuggestionOfOld", also("[filter]\nyaw_momnt_error = 7\n"),
     R"(car.toml:3: [filter] yaw_momnt_error: unknown key; did you mean "side_slip_error"?)"},
    {"FrontAngleInDegrees", also("[filter]\nfront_angle_error = 10\n"),
     "car.toml:3: [filter] front_angle_error: 10 is not possible; it must be above 0, at most 1"},
    {"SideSlipErrorOfZero", also("[filter]\nside_slip_error = 0\n"),
     "car.toml:3: [filter] side_slip_error: 0 is not possible; it must be above 0, at most 10"},
    {"WheelSlipOfZero", also("[filter]\nwheel_slip = 0\n"),
     "car.toml:3: [filter] wheel_slip: 0 is not possible; it must be above 0, at most 1"},
    {"DelayInMilliseconds", also("[steering]\ndelay = 60\n"),
     "car.toml:3: [steering] delay: 60 is not possible; it must be 0 to 0.5 (s)"},
    {"LagInMilliseconds", also("[steering]\nlag = 100\n"),
     "car.toml:3: [steering] lag: 100 is not possible; it must be 0 to 1 (s)"},
    {"ServoThatStandsStill", also("[steering]\nrate_limit = 0\n"),
     "car.toml:3: [steering] rate_limit: 0 is not possible; it must be greater than 0"},
    {"MisspeltServo", also("[steering]\nrate_limt = 3\n"),
     R"(car.toml:3: [steering] rate_limt: unknown key; did you mean "rate_limit"?)"},
    {"MisspeltSteering", also("[steerin]\n"),
     R"(car.toml:2: steerin: unknown key; did you mean "steering"?)"},
    {"GripOfZero", vehicle("grip_front = 0"),
     "car.toml:2: [vehicle] grip_front: 0 is not possible; it must be greater than 0"},
    {"MisspeltGrip", vehicle("grip_rea = 9"),
     R"(car.toml:2: [vehicle] grip_rea: unknown key; did you mean "grip_rear"?)"},
    {"GradientInDegrees", also("[imu]\nroll_gradient = 7\n"),
     "car.toml:3: [imu] roll_gradient: 7 is not possible; it must be -0.5 to 0.5 (rad per g)"},
    {"MisspeltGradient", also("[imu]\npitch_gradent = 0.05\n"),
     R"(car.toml:3: [imu] pitch_gradent: unknown key; did you mean "pitch_gradient"?)"},
    {"MountingInDegrees", also("[imu]\nyaw = 90\n"),
     "car.toml:3: [imu] yaw: 90 is not possible; it must be -3.15 to 3.15 (rad)"},
    {"NoPose", also("[initial]\n"), "car.toml:2: [initial] pose: is missing"},
    {"ShortPose", also("[initial]\npose = [0, 0]\n"),
     "car.toml:3: [initial] pose: must be a list of 3 numbers"},
    {"PoseFarAway", also("[initial]\npose = [0, 0, 1e17]\n"),
     "car.toml:3: [initial] pose: is too far away; x and y must be within 1e8 m, yaw within 1e6 "
     "rad"},
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
    {"ReferenceIsThreeNumbers", also("[reference]\nlever_arm = [0.1, 0]\n"),
     "car.toml:3: [reference] lever_arm: must be a list of 3 numbers"},
    {"EmptySocket", also("[camera]\nsocket = \"\"\n"),
     "car.toml:3: [camera] socket: is empty; it must name a file"},
    {"UnknownLevel", also("[log]\nlevel = \"warning\"\n"),
     R"(car.toml:3: [log] level: "warning" is not known; did you mean "warn"?)"},
    {"ControlCharacter", also("[shm]\nname = \"/a\\nb\"\n"),
     "car.toml:3: [shm] name: holds a control character"},
};

INSTANTIATE_TEST_SUITE_P(All, ConfigMistake, testing::ValuesIn(mistakes),
                         [](const auto& test) { return std::string(test.param.name); });

}  // namespace
}  // namespace odomd::daemon::config_mistakes_test
