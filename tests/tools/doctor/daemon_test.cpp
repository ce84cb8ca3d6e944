// Mistakes of a running daemon, planted in its status.
#include "tools/doctor/daemon.hpp"

#include <nlohmann/json.hpp>

#include "tests/diagnostics.hpp"
#include "tests/gtest.hpp"
#include "tests/tools/doctor/sound_status.hpp"

namespace odomd::tools::doctor::daemon_test {
namespace {

using diagnostics::Diagnostics;
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

Diagnostics of(const Changes& changes) {
  return examine_daemon(with(changes), Machine{});
}

TEST(Daemon, ThatIsSoundGivesNothing) {
  EXPECT_THAT(of({}), IsEmpty());
  EXPECT_THAT(examine_daemon(json::object({{"version", ODOMD_VERSION}}), Machine{}), IsEmpty());
}

TEST(Daemon, OfAnotherVersionIsNamedWithItsService) {
  EXPECT_THAT(
      of({{"/version", "0.0.1"}, {"/shm", "/run/odomd/can_front/pose"}}),
      ElementsAre(Named("other_version", "0.0.1", HasSubstr("systemctl restart odomd@can_front"))));
}

TEST(Daemon, ThatTheMachineRefusesIsNamedWithTheLimits) {
  const json status =
      with({{"/realtime/priority", 0},
            {"/realtime/memory_locked", false},
            {"/realtime/dma_latency_held", false},
            {"/realtime/refusals", {"thread odomd-beat is not pinned to CPU 9: x; set y"}},
            {"/beat/missed", 5'000}});  // a consequence
  EXPECT_THAT(examine_daemon(status, Machine{}),
              ElementsAre(Named("no_realtime_priority"), Named("memory_not_locked"),
                          Named("cpu_not_pinned", "CPU 9")));
  Machine machine;
  machine.deepest_sleep_us = 300.0;
  EXPECT_THAT(examine_daemon(status, machine), Contains(Named("cpus_sleep_deeply")));
}

TEST(Daemon, WhoseBeatIsLateOrTooLongIsNamed) {
  EXPECT_THAT(of({{"/beat/missed", 100}}), ElementsAre(Named("beat_wakes_late", "100 of 20100")));
  EXPECT_THAT(of({{"/beat/missed", 19}}), IsEmpty());
  EXPECT_THAT(of({{"/beat/missed", 10'000}, {"/beat/execution_us/p999", 7'500.0}}),
              ElementsAre(Named("ticks_too_long", "7.5 ms")));
}

TEST(Daemon, WhoseFramesAreLostOrDoNotComeIsNamed) {
  EXPECT_THAT(of({{"/can/0/lost", 40}}), ElementsAre(Named("frames_lost", "40 frames")));
  EXPECT_THAT(of({{"/can/0/controller_overflows", 40}}),
              ElementsAre(Named("controller_overflows", "40 frames")));

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

TEST(Daemon, WhoseMessagesAreMissingOrUselessIsNamed) {
  Changes changes{{"/messages/0/age_s", nullptr},
                  {"/messages/0/verdicts", {{"decoded", 0}, {"too_short", 0}}}};
  EXPECT_THAT(of(changes), ElementsAre(Named("message_missing", "IMU")));
  changes.emplace_back("/messages/0/verdicts/too_short", 700);
  EXPECT_THAT(of(changes), ElementsAre(Named("message_without_value", "700")));
  changes.emplace_back("/uptime_s", 0.5);  // frames may still come
  EXPECT_THAT(of(changes), IsEmpty());
}

TEST(Daemon, WhoseSourcesAreFlaggedIsNamed) {
  for (const auto& [flag, kind] :
       {std::pair{"frozen", "frozen"}, std::pair{"out_of_range", "out_of_range"},
        std::pair{"drifting", "contradicts_others"}, std::pair{"non_finite", "not_a_number"},
        std::pair{"failed_protection", "protection_failed"}})
    EXPECT_THAT(of({{"yaw_rate/flag", flag}, {"yaw_rate/healthy", false}}),
                ElementsAre(Named(kind, "yaw_rate")))
        << flag;
  // Slip is temporary.
  Changes changes{{"wheel_rear/flag", "slipping"}, {"wheel_rear/healthy", false}};
  EXPECT_THAT(of(changes), IsEmpty());
  changes.emplace_back("yaw_rate/inconsistent", true);
  EXPECT_THAT(of(changes), ElementsAre(Named("inconsistent", "yaw_rate")));
}

TEST(Daemon, WhoseFilterHasNotLearntOrHasStoppedIsNamed) {
  EXPECT_THAT(of({{"/conditions", {"camera_refused", "bias_unlearnt", "scale_implausible"}}}),
              ElementsAre(Named("camera_refused", "a connection was refused"),
                          Named("bias_unlearnt", "the gyro's bias is not known",
                                HasSubstr("stand for 2 s")),
                          Named("scale_implausible", "far from its configured value")));
  EXPECT_THAT(of({{"/conditions", {"model_fault"}}}), ElementsAre(Named("model_fault")));
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
  EXPECT_THAT(of(miswired), ElementsAre(Named("left_right_swapped", "wheel_front_left, wheel_rear",
                                              HasSubstr("can.signals.wheel_front_left"))));
  EXPECT_THAT(of(overdue),
              ElementsAre(Named("signal_overdue", "wheel_front_left, wheel_rear: last came 3.2 s",
                                HasSubstr("candump can0"))));
}

TEST(Daemon, WhoseSigmasDoNotFitGetsTheFactor) {
  EXPECT_THAT(
      of({{"wheel_rear/innovations/mean_nis", 9.0}}),
      ElementsAre(Named("sigma_off", "3 times", HasSubstr("can.signals.wheel_rear.sigma by 3"))));
  Changes changes{{"wheel_rear/innovations/mean_nis", 0.01}};
  EXPECT_THAT(of(changes), ElementsAre(Named("sigma_off", "0.1 times")));
  changes.emplace_back("wheel_rear/innovations/gated", 400);  // the cause
  EXPECT_THAT(of(changes), ElementsAre(Named("often_gated", "40 %")));
  EXPECT_THAT(of({changes[0], {"wheel_rear/innovations/count", 40}}), IsEmpty());  // too few
}

TEST(Daemon, WhoseCameraIsSilentOrWrongIsNamed) {
  Changes changes{{"camera/age_s", nullptr}, {"/mode", "initialising"}};
  EXPECT_THAT(of(changes), ElementsAre(Named("camera_silent", "waits")));
  changes.emplace_back("/camera/malformed", 90);
  EXPECT_THAT(of(changes), ElementsAre(Named("camera_messages_malformed", "90")));
  changes.emplace_back("/camera/socket", "");  // not configured
  EXPECT_THAT(of(changes), IsEmpty());
  EXPECT_THAT(of({{"camera/verdicts", {{"fused", 10}, {"too_old", 90}}}}),
              ElementsAre(Named("camera_times", "90 of its 100")));
}

}  // namespace
}  // namespace odomd::tools::doctor::daemon_test
