// odom doctor as a command: its parts, output and exit status; and the mistakes of a running
// daemon, planted in its status.
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
// Each file has more.

#include "tests/diagnostics.hpp"
#include "tests/tools/own_daemon.hpp"
#include "tests/tools/scratch.hpp"
#include "tools/doctor/doctor.hpp"

namespace odomd::tools::doctor::doctor_command_test {
namespace {

using nlohmann::json;
using namespace std::string_literals;
using diagnostics::Named;
using Changes = std::vector<std::pair<std::string, json>>;
using Found = ::testing::Matcher<const diagnostics::Diagnostics&>;

json sound_source(const std::string& name, int dimension) {
  return {{"name", name},
          {"configured", true},
          {"healthy", true},
          {"flag", "ok"},
          {"wiring", "ok"},
          {"inconsistent", false},
          {"age_s", 0.004},
          {"timeout_s", 0.03},
          {"verdicts", {{"fused", 1'000}, {"gated", 0}, {"too_old", 0}, {"future", 0}}},
          {"innovations",
           {{"count", 1'000}, {"gated", 3}, {"dimension", dimension}, {"mean_nis", dimension}}}};
}

json sound_message(const std::string& name) {
  return {{"name", name},
          {"id", 288},
          {"age_s", 0.004},
          {"verdicts", {{"decoded", 1'000}, {"too_short", 0}}}};
}

json sound_status() {
  return {{"version", ODOMD_VERSION},
          {"uptime_s", 100.0},
          {"shm", "/odomd"},
          {"mode", "tracking"},
          {"conditions", json::array()},
          {"beat",
           {{"period_s", 0.005},
            {"ticks", 20'000},
            {"missed", 1},
            {"overruns", 0},
            {"wakeup_us", {{"max", 4'000.0}}},
            {"execution_us", {{"p999", 80.0}}}}},
          {"can",
           {{{"name", "can0"},
             {"link", "up"},
             {"received", 50'000},
             {"lost", 0},
             {"controller_overflows", 0}}}},
          {"messages", {sound_message("IMU"), sound_message("WHEELS")}},
          {"sources",
           {sound_source("yaw_rate", 1), sound_source("wheel_front_left", 1),
            sound_source("wheel_rear", 1), sound_source("camera", 3)}},
          {"camera", {{"socket", "/run/odomd/camera.sock"}, {"messages", 900}, {"malformed", 0}}},
          {"realtime",
           {{"priority", 45},
            {"memory_locked", true},
            {"dma_latency_held", true},
            {"refusals", json::array()}}}};
}

/// A drive of `odom sim`, made once.
std::string drive() {
  static const SharedDrive made{"--duration 12"};
  return made.folder.string();
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
  const std::string config = drive() + "/grams.toml";
  must_run("sed 's/mass = 2.985/mass = 2985/' " + drive() + "/car.toml >" + config);
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

json& source(json& status, const std::string& name) {
  for (json& one : status["sources"])
    if (one["name"] == name) return one;
  throw std::invalid_argument(name);
}

/// A sound status with changed values, which JSON pointers select; "yaw_rate/flag" selects the flag
/// of a source.
json with(const Changes& changes) {
  json status = sound_status();
  for (const auto& [where, value] : changes) {
    const std::size_t slash = where.find('/');
    json& in = slash == 0 ? status : source(status, where.substr(0, slash));
    in[json::json_pointer(where.substr(slash))] = value;
  }
  return status;
}

TEST(Daemon, GetsAFindingForEachMistake) {
  Machine sleepy;
  sleepy.deepest_sleep_us = 300.0;
  const std::pair<const char*, json> camera_waits{"/mode", "initialising"},
      camera_silent{"camera/age_s", nullptr}, malformed{"/camera/malformed", 90};
  const std::pair<const char*, json> never{"/messages/0/age_s", nullptr},
      useless{"/messages/0/verdicts", {{"decoded", 0}, {"too_short", 700}}};
  const std::pair<const char*, json> slips{"wheel_rear/flag", "slipping"},
      ill{"wheel_rear/healthy", false}, scatters{"wheel_rear/innovations/mean_nis", 0.01};
  struct Case {
    Changes changes;
    Found found;
    Machine machine{};
  };
  const Case cases[]{
      {{}, IsEmpty()},
      {{{"/version", "0.0.1"}, {"/shm", "/run/odomd/can_front/pose"}},
       ElementsAre(
           Named("other_version", "0.0.1", HasSubstr("systemctl restart odomd@can_front")))},
      // The machine refuses the daemon's real-time rights; the missed ticks are a consequence.
      {{{"/realtime/priority", 0},
        {"/realtime/memory_locked", false},
        {"/realtime/dma_latency_held", false},
        {"/realtime/refusals", {"thread odomd-beat is not pinned to CPU 9: x; set y"}},
        {"/beat/missed", 5'000}},
       ElementsAre(Named("no_realtime_priority"), Named("memory_not_locked"),
                   Named("cpu_not_pinned", "CPU 9"))},
      {{{"/realtime/dma_latency_held", false}}, ElementsAre(Named("cpus_sleep_deeply")), sleepy},
      // The daemon's ticks are late or take too long.
      {{{"/beat/missed", 100}}, ElementsAre(Named("beat_wakes_late", "100 of 20100"))},
      {{{"/beat/missed", 19}}, IsEmpty()},
      {{{"/beat/missed", 10'000}, {"/beat/execution_us/p999", 7'500.0}},
       ElementsAre(Named("ticks_too_long", "7.5 ms"))},
      // Frames are lost; messages are missing or useless (not reported right after the start).
      {{{"/can/0/lost", 40}}, ElementsAre(Named("frames_lost", "40 frames"))},
      {{{"/can/0/controller_overflows", 40}},
       ElementsAre(Named("controller_overflows", "40 frames"))},
      {{never, {"/messages/0/verdicts", {{"decoded", 0}, {"too_short", 0}}}},
       ElementsAre(Named("message_missing", "IMU"))},
      {{never, useless}, ElementsAre(Named("message_without_value", "700"))},
      {{never, useless, {"/uptime_s", 0.5}}, IsEmpty()},
      // Wheel slip is temporary, so it is no finding.
      {{slips, ill}, IsEmpty()},
      {{slips, ill, {"yaw_rate/inconsistent", true}},
       ElementsAre(Named("inconsistent", "yaw_rate"))},
      // The filter has not learnt or has stopped.
      {{{"/conditions", {"camera_refused", "bias_unlearnt", "scale_implausible"}}},
       ElementsAre(
           Named("camera_refused", "a connection was refused"),
           Named("bias_unlearnt", "the gyro's bias is not known", HasSubstr("stand for 2 s")),
           Named("scale_implausible", "far from its configured value"))},
      {{{"/conditions", {"model_fault"}}}, ElementsAre(Named("model_fault"))},
      // Sigmas do not fit. Not reported if gating is the cause, or if there are too few samples.
      {{{"wheel_rear/innovations/mean_nis", 9.0}},
       ElementsAre(Named("sigma_off", "3 times", HasSubstr("can.signals.wheel_rear.sigma by 3")))},
      {{scatters}, ElementsAre(Named("sigma_off", "0.1 times"))},
      {{scatters, {"wheel_rear/innovations/gated", 400}},
       ElementsAre(Named("often_gated", "40 %"))},
      {{scatters, {"wheel_rear/innovations/count", 40}}, IsEmpty()},
      // The camera is silent or wrong, or not configured.
      {{camera_silent, camera_waits}, ElementsAre(Named("camera_silent", "waits"))},
      {{camera_silent, camera_waits, malformed},
       ElementsAre(Named("camera_messages_malformed", "90"))},
      {{camera_silent, camera_waits, malformed, {"/camera/socket", ""}}, IsEmpty()},
      {{{"camera/verdicts", {{"fused", 10}, {"too_old", 90}}}},
       ElementsAre(Named("camera_times", "90 of its 100"))},
  };
  for (const auto& [changes, found, machine] : cases)
    EXPECT_THAT(examine_daemon(with(changes), machine), found) << json(changes);
  for (const auto& [flag, kind] :
       {std::pair{"frozen", "frozen"}, std::pair{"out_of_range", "out_of_range"},
        std::pair{"drifting", "contradicts_others"}, std::pair{"non_finite", "not_a_number"},
        std::pair{"failed_protection", "protection_failed"}})
    EXPECT_THAT(
        examine_daemon(with({{"yaw_rate/flag", flag}, {"yaw_rate/healthy", false}}), Machine{}),
        ElementsAre(Named(kind, "yaw_rate")))
        << flag;
  EXPECT_THAT(examine_daemon(json::object({{"version", ODOMD_VERSION}}), Machine{}), IsEmpty());
}

TEST(Daemon, WithoutFramesIsNamedOnce) {
  // A bus without a frame: its messages and sources have no finding of their own.
  json status = with({{"/can/0/received", 0}});
  for (json& message : status["messages"]) {
    message["age_s"] = nullptr;
    message["verdicts"] = {{"decoded", 0}};
  }
  for (json& one : status["sources"]) one["healthy"] = one["name"] == "camera";
  const auto found = [&status] { return examine_daemon(status, Machine{}); };
  EXPECT_THAT(found(), ElementsAre(Named("no_frames", "can0")));

  // The bus falls silent later.
  status["can"][0]["received"] = 5'000;
  status["messages"][0]["age_s"] = 12.0;
  EXPECT_THAT(found(), ElementsAre(Named("no_frames", "12 s")));
  status["can"][0]["link"] = "down";  // examine_link() reports this
  EXPECT_THAT(found(), IsEmpty());
  status["can"][0]["link"] = "ended";  // a log has ended: no fault
  EXPECT_THAT(found(), IsEmpty());
}

TEST(Daemon, WhoseWiringIsWrongOrWhoseSignalsAreOverdueIsNamedOnce) {
  Changes miswired{{"yaw_rate/inconsistent", true}}, overdue;
  for (const std::string name : {"wheel_front_left", "wheel_rear"}) {
    miswired.insert(miswired.end(), {{name + "/wiring", "left_right_swapped"},
                                     {name + "/flag", "drifting"},
                                     {name + "/healthy", false}});
    overdue.insert(
        overdue.end(),
        {{name + "/flag", "timed_out"}, {name + "/healthy", false}, {name + "/age_s", 3.2}});
  }
  EXPECT_THAT(examine_daemon(with(miswired), Machine{}),
              ElementsAre(Named("left_right_swapped", "wheel_front_left, wheel_rear",
                                HasSubstr("can.signals.wheel_front_left"))));
  EXPECT_THAT(examine_daemon(with(overdue), Machine{}),
              ElementsAre(Named("signal_overdue", "wheel_front_left, wheel_rear: last came 3.2 s",
                                HasSubstr("candump can0"))));
}

}  // namespace
}  // namespace odomd::tools::doctor::doctor_command_test
