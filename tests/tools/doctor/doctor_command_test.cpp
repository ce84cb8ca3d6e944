// odom doctor as a command: its parts, output and exit status.
//
// The 25 mistakes that the doctor must find, each made in a test that also checks its fix:
//   wiring, whole_drive_test.cpp    signs of gyro, steering and lateral accelerometer; exchanged
//                                   accelerometer axes, sides, axles; accelerometers in g, wheels
//                                   in km/h, gyro in degrees; a mirrored camera
//   configuration, whole_drive_test.cpp
//                                   mass in grams, axles in millimetres, a wheel's radius, a role
//                                   that is not mapped, a latency
//   the machine, machine_test.cpp   no PREEMPT_RT, no real-time priority, memory not locked, CPUs
//                                   that sleep deeply, a changing CPU frequency
//   the bus, bus_test.cpp           down, no restart-ms, errors (bit rate), a message that is
//                                   missing, another rate
// Each file has more; daemon_test.cpp has the mistakes of a running daemon.
#include <nlohmann/json.hpp>

#include "tests/gtest.hpp"
#include "tests/tools/doctor/sound_status.hpp"
#include "tests/tools/own_daemon.hpp"
#include "tests/tools/scratch.hpp"

namespace odomd::tools::doctor::doctor_command_test {
namespace {

using nlohmann::json;
using namespace std::string_literals;

/// A drive of `odom sim`, made once.
std::string drive() {
  static const SharedDrive made{"--duration 12"};
  return made.folder.string();
}

/// Its car.toml, with `from` replaced.
std::string config_with(const Scratch& scratch, const std::string& from, const std::string& to) {
  std::string text = contents(drive() + "/car.toml");
  const std::size_t at = text.find(from);
  EXPECT_NE(at, std::string::npos) << from;
  text.replace(at, from.size(), to);
  scratch.write("car.dbc", contents(drive() + "/car.dbc"));
  return scratch.write("car.toml", text).string();
}

json part_of(const Outcome& outcome, const std::string& name) {
  const json result = json::parse(outcome.out);
  for (const json& part : result.at("parts"))
    if (part.at("name") == name) return part;
  ADD_FAILURE() << name << " is no part of " << outcome.out;
  return {};
}

TEST(Doctor, RefusesWrongUsageAndUnusableInput) {
  const Scratch scratch;
  const std::string none = scratch.path("none").string();
  for (const std::string& line :
       {"--nonsense"s, "--can can0"s, "--for 3"s, "--drive " + none, "--socket " + none,
        "--config " + none, "--drive " + drive() + " --can can0 --config car.toml",
        "--can can0 --config car.toml --for 0"s}) {
    const Outcome outcome = run_shell("odom doctor " + line);
    EXPECT_EQ(outcome.status, 2) << line << '\n' << outcome.out;
    EXPECT_EQ(outcome.out, "") << line;
    EXPECT_THAT(outcome.err, StartsWith("odom doctor: ")) << line;
  }
}

TEST(Doctor, FindsNothingInASoundDrive) {
  const Outcome text = run_shell("odom doctor --drive " + drive());
  EXPECT_EQ(text.status, 0) << text.out;
  EXPECT_THAT(text.out, AllOf(StartsWith(drive() + ": fine"), EndsWith("\nnothing found\n")));
  EXPECT_EQ(text.err, "");
  const json result = json::parse(must_run("odom doctor --json --drive " + drive()));
  EXPECT_EQ(result.at("findings"), 0);
  EXPECT_TRUE(result.at("parts").at(0).at("examined"));
}

TEST(Doctor, NamesAMistakeWithItsCodeAndItsFix) {
  const Scratch scratch;
  const std::string config = config_with(scratch, "mass = 2.985", "mass = 2985");
  const std::string line = "odom doctor --drive " + drive() + " --config " + config;
  const Outcome text = run_shell(line);
  EXPECT_THAT(text, Ends(1, ""));
  EXPECT_THAT(text.out, HasSubstr("[W102]\n    fix: give mass in kilograms"));
  EXPECT_THAT(text.out, EndsWith("\n1 finding\n"));
  for (const auto& [command, part] :
       {std::pair{line, drive()}, {"odom doctor --config " + config, config}}) {
    const Outcome outcome = run_shell(command + " --json");
    EXPECT_EQ(outcome.status, 1);
    EXPECT_EQ(part_of(outcome, part).at("diagnostics").at(0).at("code"), "W102");
  }
}

TEST(Doctor, ExaminesTheMachineAndTheDaemon) {
  const Scratch scratch;
  json status = sound_status();
  status["can"][0]["name"] = "no_such_bus";
  status["sources"][0]["wiring"] = "sign";
  status["sources"][0]["flag"] = "drifting";
  const std::string socket = scratch.path("status.sock").string();
  const AnsweringSocket daemon(socket, status.dump());
  const Outcome outcome = run_shell("odom doctor --json --socket " + socket);
  EXPECT_EQ(outcome.status, 1) << outcome.err;
  const json found = part_of(outcome, "odomd").at("diagnostics");
  ASSERT_EQ(found.size(), 1U) << found;
  EXPECT_EQ(found[0].at("name"), "wrong_sign");
  EXPECT_THAT(found[0].at("fix"), HasSubstr("can.signals.yaw_rate.scale"));
  EXPECT_EQ(part_of(outcome, "bus no_such_bus").at("diagnostics").at(0).at("code"), "W701");
  EXPECT_TRUE(part_of(outcome, "machine").at("diagnostics").is_array());
}

TEST(Doctor, SaysThatNoDaemonRuns) {
  const Scratch empty;
  const Outcome outcome =
      run_shell("XDG_RUNTIME_DIR=" + empty.path("").string() + " odom doctor --json");
  EXPECT_LE(outcome.status, 1) << outcome.err;  // depends on this machine
  const json result = json::parse(outcome.out);
  EXPECT_EQ(result.at("findings") == 0, outcome.status == 0);
  EXPECT_THAT(part_of(outcome, "odomd").at("diagnostics"), ::testing::IsEmpty());
}

TEST(Doctor, NamesAnInterfaceThatIsMissingWithoutListening) {
  const Outcome outcome =
      run_shell("odom doctor --json --can no_such_bus --for 600 --config " + drive() + "/car.toml");
  EXPECT_EQ(outcome.status, 1) << outcome.err;
  EXPECT_EQ(part_of(outcome, "bus no_such_bus").at("diagnostics").at(0).at("name"),
            "interface_missing");
}

}  // namespace
}  // namespace odomd::tools::doctor::doctor_command_test
