// Mistakes of a running daemon, planted in its status.
#include "tools/doctor/daemon.hpp"

#include <nlohmann/json.hpp>

#include "tests/diagnostics.hpp"
#include "tests/gtest.hpp"
#include "tests/tools/doctor/sound_status.hpp"

namespace odomd::tools::doctor::daemon_test {
namespace {

using diagnostics::Diagnostics;
using diagnostics::fix_of;
using diagnostics::Named;
using nlohmann::json;

Diagnostics of(const json& status) {
  return examine_daemon(status, Machine{});
}

json& source(json& status, const std::string& name) {
  for (json& one : status["sources"])
    if (one["name"] == name) return one;
  throw std::invalid_argument(name);
}

TEST(Daemon, ThatIsSoundGivesNothing) {
  EXPECT_THAT(of(sound_status()), IsEmpty());
  EXPECT_THAT(of(json::object({{"version", ODOMD_VERSION}})), IsEmpty());
}

TEST(Daemon, OfAnotherVersionIsNamedWithItsService) {
  json status = sound_status();
  status["version"] = "0.0.1";
  status["shm"] = "/run/odomd/can_front/pose";
  const Diagnostics found = of(status);
  ASSERT_THAT(found, ElementsAre(Named("other_version", "0.0.1")));
  EXPECT_THAT(fix_of(found[0]), HasSubstr("systemctl restart odomd@can_front"));
}

TEST(Daemon, ThatTheMachineRefusesIsNamedWithTheLimits) {
  json status = sound_status();
  status["realtime"] = {{"priority", 0},
                        {"memory_locked", false},
                        {"dma_latency_held", false},
                        {"refusals", {"thread odomd-beat is not pinned to CPU 9: x; set y"}}};
  status["beat"]["missed"] = 5'000;  // a consequence
  EXPECT_THAT(of(status), ElementsAre(Named("no_realtime_priority"), Named("memory_not_locked"),
                                      Named("cpu_not_pinned", "CPU 9")));
  Machine machine;
  machine.deepest_sleep_us = 300.0;
  EXPECT_THAT(examine_daemon(status, machine), ::testing::Contains(Named("cpus_sleep_deeply")));
}

TEST(Daemon, WhoseBeatIsLateOrTooLongIsNamed) {
  json status = sound_status();
  status["beat"]["missed"] = 100;
  EXPECT_THAT(of(status), ElementsAre(Named("beat_wakes_late", "100 of 20100")));
  status["beat"]["missed"] = 19;
  EXPECT_THAT(of(status), IsEmpty());
  status["beat"]["missed"] = 10'000;
  status["beat"]["execution_us"]["p999"] = 7'500.0;
  EXPECT_THAT(of(status), ElementsAre(Named("ticks_too_long", "7.5 ms")));
}

TEST(Daemon, WhoseFramesAreLostOrDoNotComeIsNamed) {
  json status = sound_status();
  status["can"][0]["lost"] = 40;
  EXPECT_THAT(of(status), ElementsAre(Named("frames_lost", "40 frames")));
  status["can"][0]["lost"] = 0;
  status["can"][0]["controller_overflows"] = 40;
  EXPECT_THAT(of(status), ElementsAre(Named("controller_overflows", "40 frames")));

  // A bus without a frame: its messages and sources have no finding of their own.
  status = sound_status();
  status["can"][0]["received"] = 0;
  for (json& message : status["messages"]) {
    message["age_s"] = nullptr;
    message["verdicts"] = {{"decoded", 0}};
  }
  for (json& one : status["sources"]) one["healthy"] = one["name"] == "camera";
  EXPECT_THAT(of(status), ElementsAre(Named("no_frames", "can0")));

  // The bus falls silent later.
  status["can"][0]["received"] = 5'000;
  status["messages"][0]["age_s"] = 12.0;
  EXPECT_THAT(of(status), ElementsAre(Named("no_frames", "12 s")));
  status["can"][0]["link"] = "down";  // examine_link() reports this
  EXPECT_THAT(of(status), IsEmpty());
  status["can"][0]["link"] = "ended";  // a log: no fault
  EXPECT_THAT(of(status), IsEmpty());
}

TEST(Daemon, WhoseMessagesAreMissingOrUselessIsNamed) {
  json status = sound_status();
  status["messages"][0]["age_s"] = nullptr;
  status["messages"][0]["verdicts"] = {{"decoded", 0}, {"too_short", 0}};
  EXPECT_THAT(of(status), ElementsAre(Named("message_missing", "IMU")));
  status["messages"][0]["verdicts"]["too_short"] = 700;
  EXPECT_THAT(of(status), ElementsAre(Named("message_without_value", "700")));
  status["uptime_s"] = 0.5;  // frames may still come
  EXPECT_THAT(of(status), IsEmpty());
}

TEST(Daemon, WhoseSourcesAreFlaggedIsNamed) {
  for (const auto& [flag, kind] :
       {std::pair{"frozen", "frozen"}, std::pair{"out_of_range", "out_of_range"},
        std::pair{"drifting", "contradicts_others"}, std::pair{"non_finite", "not_a_number"},
        std::pair{"failed_protection", "protection_failed"}}) {
    json status = sound_status();
    source(status, "yaw_rate")["flag"] = flag;
    source(status, "yaw_rate")["healthy"] = false;
    EXPECT_THAT(of(status), ElementsAre(Named(kind, "yaw_rate"))) << flag;
  }
  json status = sound_status();
  source(status, "wheel_rear")["flag"] = "slipping";  // slip is temporary
  source(status, "wheel_rear")["healthy"] = false;
  EXPECT_THAT(of(status), IsEmpty());
  source(status, "yaw_rate")["inconsistent"] = true;
  EXPECT_THAT(of(status), ElementsAre(Named("inconsistent", "yaw_rate")));
}

TEST(Daemon, WhoseFilterHasNotLearntIsNamed) {
  json status = sound_status();
  status["conditions"] = {"camera_refused", "bias_unlearnt", "scale_implausible"};
  Diagnostics found = of(status);
  ASSERT_FALSE(found.empty());
  EXPECT_THAT(found.front(), Named("camera_refused", "a connection was refused"));
  found.erase(found.begin());
  ASSERT_THAT(found, ElementsAre(Named("bias_unlearnt", "the gyro's bias is not known"),
                                 Named("scale_implausible", "far from its configured value")));
  EXPECT_THAT(fix_of(found[0]), HasSubstr("stand for 2 s"));
}

TEST(Daemon, WhoseWiringIsWrongIsNamedOnce) {
  json status = sound_status();
  for (const char* const name : {"wheel_front_left", "wheel_rear"}) {
    source(status, name)["wiring"] = "left_right_swapped";
    source(status, name)["flag"] = "drifting";
    source(status, name)["healthy"] = false;
  }
  source(status, "yaw_rate")["inconsistent"] = true;
  const Diagnostics found = of(status);
  ASSERT_THAT(found, ElementsAre(Named("left_right_swapped", "wheel_front_left, wheel_rear")));
  EXPECT_THAT(fix_of(found[0]), HasSubstr("can.signals.wheel_front_left"));
}

TEST(Daemon, WhoseSignalsAreOverdueIsNamedOnce) {
  json status = sound_status();
  for (const char* const name : {"wheel_front_left", "wheel_rear"}) {
    source(status, name)["flag"] = "timed_out";
    source(status, name)["healthy"] = false;
    source(status, name)["age_s"] = 3.2;
  }
  const Diagnostics found = of(status);
  ASSERT_THAT(found, ElementsAre(Named("signal_overdue",
                                       "wheel_front_left, wheel_rear: last came "
                                       "3.2 s")));
  EXPECT_THAT(fix_of(found[0]), HasSubstr("candump can0"));
}

TEST(Daemon, WhoseSigmasDoNotFitGetsTheFactor) {
  json status = sound_status();
  json& innovations = source(status, "wheel_rear")["innovations"];
  innovations["mean_nis"] = 9.0;
  Diagnostics found = of(status);
  ASSERT_THAT(found, ElementsAre(Named("sigma_off", "3 times")));
  EXPECT_THAT(fix_of(found[0]), HasSubstr("can.signals.wheel_rear.sigma by 3"));
  innovations["mean_nis"] = 0.01;
  found = of(status);
  ASSERT_THAT(found, ElementsAre(Named("sigma_off", "0.1 times")));
  innovations["count"] = 40;  // too few
  EXPECT_THAT(of(status), IsEmpty());
  innovations["count"] = 1'000;
  innovations["gated"] = 400;  // the cause
  EXPECT_THAT(of(status), ElementsAre(Named("often_gated", "40 %")));
}

TEST(Daemon, WhoseCameraIsSilentOrWrongIsNamed) {
  json status = sound_status();
  source(status, "camera")["age_s"] = nullptr;
  status["mode"] = "initialising";
  EXPECT_THAT(of(status), ElementsAre(Named("camera_silent", "waits")));
  status["camera"]["malformed"] = 90;
  EXPECT_THAT(of(status), ElementsAre(Named("camera_messages_malformed", "90")));
  status["camera"]["socket"] = "";  // not configured
  EXPECT_THAT(of(status), IsEmpty());

  status = sound_status();
  source(status, "camera")["verdicts"] = {{"fused", 10}, {"too_old", 90}};
  EXPECT_THAT(of(status), ElementsAre(Named("camera_times", "90 of its 100")));
}

TEST(Daemon, WhoseModelStoppedIsNamed) {
  json status = sound_status();
  status["conditions"] = {"model_fault"};
  EXPECT_THAT(of(status), ElementsAre(Named("model_fault")));
}

}  // namespace
}  // namespace odomd::tools::doctor::daemon_test
