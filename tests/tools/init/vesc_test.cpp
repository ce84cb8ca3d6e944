// Frames of a VESC, packed here as its documentation says, independently of our database: the
// configuration of odom init decodes them, and a drive with them gives a pose.
#include <map>
#include <numbers>

#include <fmt/format.h>

#include "tests/tools/scratch.hpp"
#include "tools/identify/common/signal_log.hpp"
#include "tools/replay/drive.hpp"

namespace odomd::tools::vesc_test {
namespace {

using nlohmann::json;

/// Payload bytes in hexadecimal.
std::string most_significant_first(std::int64_t value, int bytes) {
  std::string text;
  for (int i = bytes - 1; i >= 0; --i) text += fmt::format("{:02X}", value >> (8 * i) & 0xFF);
  return text;
}
struct Sample {
  std::string frame;
  std::map<std::string, double> values;
};

TEST(Vesc, DatabaseReadsEverySignalOfThePublishedLayout) {
  const auto big = most_significant_first;
  struct Case {
    std::string option;
    std::vector<Sample> samples;
  };
  const std::vector<Case> cases{
      {"--vesc 23 --pole-pairs 2",
       {{"00000917#" + big(-123456, 4) + big(-321, 2) + big(456, 2),
         {{"MotorERPM", -123456}, {"Current", -32.1}, {"DutyCycle", 45.6}}},
        {"00000E17#" + big(12345, 4) + big(678, 4),
         {{"ChargeUsed", 1.2345}, {"ChargeRegained", 0.0678}}},
        {"00000F17#" + big(543210, 4) + big(9, 4),
         {{"EnergyUsed", 54.321}, {"EnergyRegained", 0.0009}}},
        {"00001017#" + big(253, 2) + big(-84, 2) + big(37, 2) + big(9000, 2),
         {{"TemperatureFET", 25.3},
          {"TemperatureMotor", -8.4},
          {"CurrentIn", 3.7},
          {"PIDPosition", 180.0}}},
        {"00001B17#" + big(-600, 4) + big(168, 2) + "0000",
         {{"Tachometer", -100.0}, {"VoltageIn", 16.8}}},
        {"00003A17#" + big(3300, 2) + big(1, 2) + big(2500, 2) + big(-500, 2),
         {{"ADC1", 3.3}, {"ADC2", 0.001}, {"ADC3", 2.5}, {"PPMInput", -50.0}}}}},
      {"--vesc 0 --pole-pairs 7",
       {{"00000900#" + big(70, 4) + "00000000",
         {{"MotorERPM", 70}, {"Current", 0}, {"DutyCycle", 0}}}}},
      {"--vesc 254 --pole-pairs 7",
       {{"000009FE#" + big(2'147'483, 4) + "00000000",
         {{"MotorERPM", 2'147'483}, {"Current", 0}, {"DutyCycle", 0}}}}},
  };
  for (const Case& one : cases) {
    SCOPED_TRACE(one.option);
    const Scratch scratch;
    std::string log;
    for (std::size_t i = 0; i < one.samples.size(); ++i)
      log += fmt::format("({}.000000) can0 {}\n", 100 + i, one.samples[i].frame);
    scratch.write("bus.log", log);
    scratch.must_run("odom init --mass 3 --wheelbase 0.3 --wheel-radius 50mm " + one.option);
    const Outcome shown = scratch.run("odom dbc decode --json --dbc *-*.dbc bus.log");
    ASSERT_THAT(shown, Ends(0, ""));
    std::istringstream lines(shown.out);
    std::string line;
    for (const Sample& sample : one.samples) {
      ASSERT_TRUE(std::getline(lines, line));
      const json signals = json::parse(line).at("signals");
      EXPECT_EQ(signals.size(), sample.values.size());
      for (const auto& [name, value] : sample.values)
        EXPECT_NEAR(signals.at(name).get<double>(), value, 1e-9 * std::fabs(value) + 1e-9) << name;
    }
  }
}

/// A simulated car without wheel sensors: a VESC sends the speed of the rear axle,
/// another node the rest.
class Drive : public testing::Test {
 protected:
  static constexpr double wheel_radius = 0.033, gear_ratio = 11.8;
  static constexpr int pole_pairs = 2;

  static const Scratch& scratch() {
    static const SharedDrive made{"--seed 3", "lap"};
    return made.scratch;
  }

  /// Writes lap/NAME; `frame_of` makes a frame from a wheel's turns per second.
  template <class FrameOf>
  static void write_log(const std::string& name, int every_ns, FrameOf frame_of) {
    const tools::Drive drive = read_drive({.folder = scratch().path("lap")});
    const auto signals = signals_of(drive);
    const Series& left = signals.of(estimator::Source::wheel_rear_left);
    const Series& right = signals.of(estimator::Source::wheel_rear_right);
    std::multimap<std::string, std::string> lines;
    std::int64_t next_ns = 0;
    for (std::size_t i = 0; i < std::min(left.size(), right.size()); ++i) {
      const std::int64_t t_ns = left.t_ns[i];
      if (t_ns < next_ns) continue;
      next_ns = t_ns + every_ns;
      const double speed = 0.5 * (left.value[i] + right.value[i]);
      const std::string stamp =
          fmt::format("({}.{:06})", t_ns / 1'000'000'000, t_ns / 1000 % 1'000'000);
      lines.emplace(stamp, stamp + " can0 " +
                               frame_of(speed / (2.0 * std::numbers::pi * wheel_radius)) + "\n");
    }
    std::istringstream recorded(scratch().text("lap/drive.log"));
    for (std::string line; std::getline(recorded, line);)
      if (line.find(" 1A2#") != std::string::npos || line.find(" 1A3#") != std::string::npos)
        lines.emplace(line.substr(0, line.find(')') + 1), line + "\n");
    std::string text;
    for (const auto& line : lines) text += line.second;
    scratch().write("lap/" + name, text);
  }
  static std::string vesc_frame(double turns) {
    const auto erpm = std::lround(60.0 * turns * gear_ratio * pole_pairs);
    return "00000917#" + most_significant_first(erpm, 4) + "00000000";
  }
  [[nodiscard]] static Outcome init(const std::string& options) {
    return scratch().run(
        "cd lap && odom init --force --json --mass 2.985 --wheelbase 0.26 --front-axle 0.175 "
        "--wheel-radius 33mm --out motor.toml " +
        options);
  }
};

TEST_F(Drive, GivesAPoseFromMassAndSizesAlone) {
  write_log("vesc.log", 20'000'000, vesc_frame);
  const Outcome made =
      init("--vesc 23 --gear-ratio 11.8 --pole-pairs 2 --dbc car.dbc --can vesc.log");
  ASSERT_EQ(made.status, 0) << made.err;
  std::string roles;
  const json result = json::parse(made.out);
  for (const json& role : result.at("roles")) {
    roles += role.at("role").get<std::string>() + ' ';
    EXPECT_EQ(role.at("sure"), true) << role;
  }
  EXPECT_EQ(roles, "yaw_rate accel_x accel_y motor steering ");
  const json estimate =
      errors_of_replay(scratch(), "--config lap/motor.toml --can lap/vesc.log --initial 0,0,0",
                       "lap/truth.csv --align first");
  EXPECT_LT(estimate.at("position").at("rms").get<double>(), 0.25) << estimate;
  EXPECT_LT(estimate.at("end_error_cm_per_m").get<double>(), 0.6);
}

TEST_F(Drive, WithoutTheFramesNamesThoseThatArrive) {
  write_log("vesc.log", 20'000'000, vesc_frame);
  write_log("others.log", 20'000'000, [](double turns) {
    return "00001B17#" + most_significant_first(std::lround(turns), 4) + "00A80000";
  });
  write_log("slow.log", 200'000'000, vesc_frame);
  const std::string motor = " --pole-pairs 2 --gear-ratio 11.8 --can ";
  EXPECT_THAT(init("--vesc 42" + motor + "vesc.log"),
              Ends(2, AllOf(HasSubstr("vesc.log: VESC 42"), HasSubstr("92A"),
                            HasSubstr("it comes from VESC 23"))));
  EXPECT_THAT(init("--vesc 23" + motor + "others.log"),
              Ends(2, HasSubstr("switch it on: VESC Tool")));
  EXPECT_THAT(init("--vesc 23" + motor + "slow.log").out, HasSubstr("less than 20 times a second"));
  EXPECT_THAT(
      init("--vesc 23" + motor + "vesc.log").out,
      AllOf(HasSubstr("sends no yaw rate and no steering"), Not(HasSubstr("times a second"))));
}

TEST_F(Drive, IsNotNeededForTheFilesWhichMarkMissingNumbers) {
  const Outcome made = init("--vesc 23 --pole-pairs 2");
  ASSERT_EQ(made.status, 0) << made.err;
  EXPECT_THAT(scratch().text("lap/motor.toml"),
              AllOf(HasSubstr("# UNSURE: ratio 1"), HasSubstr("ratio = 1.0, pole_pairs = 2"),
                    HasSubstr("dbc = \"vesc-23.dbc\"")));
  scratch().must_run("odomd --check --config lap/motor.toml");
  scratch().write("lap/vesc-24.dbc", "VERSION \"mine\"\n");
  EXPECT_THAT(init("--vesc 24 --pole-pairs 2"), Ends(2, HasSubstr("vesc-24.dbc: exists already")));
  EXPECT_EQ(scratch().text("lap/vesc-24.dbc"), "VERSION \"mine\"\n");
  EXPECT_THAT(init("--vesc 25 --pole-pairs 2 --track 0.16 --dbc car.dbc").out,
              HasSubstr("VESC 25 is not mapped"));
}

TEST(Vesc, RefusesNumbersThatNoControllerHas) {
  const Scratch scratch;
  for_each_row(R"(
--vesc 255 -> --vesc
--vesc -1 -> --vesc
--vesc 4294967319 -> --vesc
--vesc 1 --vesc 2 -> --vesc
--vesc 1 -> --pole-pairs
--vesc 1 --pole-pairs 0 -> --pole-pairs
--vesc 1 --pole-pairs 2.5 -> --pole-pairs: 2.5 is not a whole number
--vesc 1 --pole-pairs 2 --gear-ratio 0 -> --gear-ratio
)",
               [&](const std::string& options, const std::string& says) {
                 EXPECT_THAT(scratch.run("odom init --mass 3 --wheelbase 0.26 --wheel-radius 33mm "
                                         "--out refused.toml " +
                                         options),
                             Ends(2, HasSubstr(says)))
                     << options;
               });
  EXPECT_FALSE(std::filesystem::exists(scratch.path("refused.toml")));
}

}  // namespace
}  // namespace odomd::tools::vesc_test
