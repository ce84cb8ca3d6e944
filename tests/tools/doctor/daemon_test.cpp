// Mistakes of a running daemon, planted in its status.
#include "tools/doctor/machine.hpp"

#include <nlohmann/json.hpp>

#include "tests/diagnostics.hpp"
#include "tests/gtest.hpp"
#include "tests/tools/doctor/sound_status.hpp"

namespace odomd::tools::doctor::daemon_test {
namespace {

using diagnostics::Named;
using nlohmann::json;

json& source(json& status, const std::string& name) {
  for (json& one : status["sources"])
    if (one["name"] == name) return one;
  throw std::invalid_argument(name);
}

/// Values to put into a sound status, by their JSON pointers; "yaw_rate/flag" is one of a source.
using Changes = std::vector<std::pair<std::string, json>>;

json with(const Changes& changes) {
  json status = sound_status();
  for (const auto& [where, value] : changes) {
    const std::size_t slash = where.find('/');
    json& in = slash == 0 ? status : source(status, where.substr(0, slash));
    in[json::json_pointer(where.substr(slash))] = value;
  }
  return status;
}

using Found = ::testing::Matcher<const diagnostics::Diagnostics&>;

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
      // The machine refuses its rights; the missed cycles are a consequence.
      {{{"/realtime/priority", 0},
        {"/realtime/memory_locked", false},
        {"/realtime/dma_latency_held", false},
        {"/realtime/refusals", {"thread odomd-beat is not pinned to CPU 9: x; set y"}},
        {"/beat/missed", 5'000}},
       ElementsAre(Named("no_realtime_priority"), Named("memory_not_locked"),
                   Named("cpu_not_pinned", "CPU 9"))},
      {{{"/realtime/dma_latency_held", false}}, ElementsAre(Named("cpus_sleep_deeply")), sleepy},
      // Its beat is late or too long.
      {{{"/beat/missed", 100}}, ElementsAre(Named("beat_wakes_late", "100 of 20100"))},
      {{{"/beat/missed", 19}}, IsEmpty()},
      {{{"/beat/missed", 10'000}, {"/beat/execution_us/p999", 7'500.0}},
       ElementsAre(Named("ticks_too_long", "7.5 ms"))},
      // Frames are lost; messages are missing or useless, but after half a second may still come.
      {{{"/can/0/lost", 40}}, ElementsAre(Named("frames_lost", "40 frames"))},
      {{{"/can/0/controller_overflows", 40}},
       ElementsAre(Named("controller_overflows", "40 frames"))},
      {{never, {"/messages/0/verdicts", {{"decoded", 0}, {"too_short", 0}}}},
       ElementsAre(Named("message_missing", "IMU"))},
      {{never, useless}, ElementsAre(Named("message_without_value", "700"))},
      {{never, useless, {"/uptime_s", 0.5}}, IsEmpty()},
      // A slip is temporary.
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
      // Sigmas do not fit, unless much was gated, the cause, or too few samples came.
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
  status["can"][0]["link"] = "ended";  // a log: no fault
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
}  // namespace odomd::tools::doctor::daemon_test
