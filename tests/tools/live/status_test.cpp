// odom status: how it asks for the document and prints it.
#include <odom/odom.h>

#include <nlohmann/json.hpp>

#include "daemon/housekeeping/status.hpp"
#include "tests/gtest.hpp"
#include "tests/tools/own_daemon.hpp"
#include "tests/tools/scratch.hpp"
#include "tools/diagnostics/conditions.hpp"
#include "tools/live/status_text.hpp"

namespace odomd::tools::status_test {
namespace {

using nlohmann::json;
using ::testing::MatchesRegex;

json document(double uptime, std::uint64_t ticks) {
  return json{{"version", "0.1.0"},
              {"instance", "a1"},
              {"pid", 42},
              {"uptime_s", uptime},
              {"config", "car.toml"},
              {"shm", "/odomd"},
              {"model", "paper"},
              {"mode", "degraded"},
              {"conditions", {"bus_down", "from_the_future"}},
              {"pose",
               {{"tick", ticks},
                {"age_s", 0.0021},
                {"x", 1.0},
                {"y", -2.0},
                {"yaw", 0.5},
                {"sigma_x", 0.01},
                {"sigma_y", 0.02},
                {"sigma_yaw", 0.0},
                {"reset_count", 1}}},
              {"beat", {{"ticks", ticks}, {"missed", 3}}},
              {"can",
               {{{"name", "can0"},
                 {"link", "up"},
                 {"received", 10 * ticks},
                 {"lost", 0},
                 {"hardware_fallbacks", 5},
                 {"bus_offs", 0},
                 {"controller",
                  {{"state", "error_passive"},
                   {"restart_ms", 100},
                   {"bit_timing", {{"bitrate", 500000}, {"sample_point", 0.875}}},
                   {"modes", {"fd"}},
                   {"tx_errors", 130},
                   {"rx_errors", nullptr},
                   {"bus_offs", 2}}}},
                {{"name", "vcan0"},
                 {"link", "up"},
                 {"received", 0},
                 {"lost", 0},
                 {"controller", nullptr}}}},
              {"sources",
               {{{"name", "yaw_rate"},
                 {"configured", true},
                 {"healthy", false},
                 {"age_s", nullptr},
                 {"last_verdict", "gated"},
                 {"test_ratio", 1.3},
                 {"innovation", {-0.0215}},
                 {"innovations",
                  {{"count", ticks}, {"dimension", 1}, {"mean_nis", 1.06}, {"inside_95", 0.943}}},
                 {"verdicts", {{"fused", ticks}, {"gated", 7}}}},
                {{"name", "motor"}, {"configured", false}}}}};
}

TEST(StatusText, ShowsModeConditionsPoseAndSources) {
  const std::string text = status_as_text(document(10.0, 2000), {});
  for (const char* part :
       {"mode        degraded\n", "bus_down: a bus is down or gone\n", "from_the_future\n",
        "y -2.000 ± 0.020 m", "2000 ticks, 3 missed", ", 1 reset\n", "overdue", "7 gated"})
    EXPECT_THAT(text, HasSubstr(part));
  EXPECT_THAT(text, Not(HasSubstr("motor")));
}

TEST(StatusText, NamesWhatIsWiredWronglyAndWhatScatters) {
  json wrong = document(10.0, 2000);
  for (const auto& [flag, says] : {std::pair{"frozen", "yaw_rate  frozen "},
                                   {"failed_protection", "yaw_rate  failed protection "},
                                   {"drifting", "drifting"}}) {
    wrong["sources"][0]["flag"] = flag;
    EXPECT_THAT(status_as_text(wrong, {}), HasSubstr(says));
  }
  wrong["sources"][0]["wiring"] = "left_right_swapped";
  EXPECT_THAT(status_as_text(wrong, {}), HasSubstr("miswired: left right swapped"));
  for (const char* const before : {"failed_protection", "out_of_range", "non_finite", "frozen"}) {
    wrong["sources"][0]["flag"] = before;
    EXPECT_THAT(status_as_text(wrong, {}), ::testing::Not(HasSubstr("miswired:"))) << before;
  }
  wrong["sources"][0]["flag"] = "drifting";
  wrong["sources"][0]["wiring"] = "ok";
  EXPECT_THAT(status_as_text(wrong, {}), HasSubstr("drifting"));
  wrong["sources"][0]["healthy"] = true;
  wrong["sources"][0]["inconsistent"] = true;
  EXPECT_THAT(status_as_text(wrong, {}), HasSubstr("inconsistent"));
}

TEST(StatusText, LeavesWholeTurnsOutOfTheHeading) {
  json turned = document(10.0, 2000);
  turned["pose"]["yaw"] = 12.3;  // two turns less 15.26 degrees
  EXPECT_THAT(status_as_text(turned, {}), HasSubstr("yaw -15.26 ± 0.00 deg"));
}

TEST(StatusText, ShowsInnovationsWhereTheModelTestsItsSamples) {
  json now = document(10.0, 2000);
  EXPECT_THAT(status_as_text(now, {}),
              MatchesRegex("(.|\n)* innovation +NIS +in 95 %\n"
                           "yaw_rate(.|\n)*test ratio 1.30\\) +-0.0215 +1.06 +94.3\n(.|\n)*"));
  now["sources"][0]["innovations"] = {
      {"count", 0}, {"dimension", 0}, {"mean_nis", nullptr}, {"inside_95", nullptr}};
  EXPECT_THAT(status_as_text(now, {}), Not(HasSubstr("NIS")));
}

TEST(StatusText, ShowsTheNoiseOfSourcesWhereTheModelEstimatesIt) {
  json now = document(10.0, 2000);
  const auto source = [](const char* name, const json& sigma, const json& noise) {
    return json{{"name", name}, {"configured", true}, {"sigma", sigma}, {"noise", noise}};
  };
  const auto estimated = [](const json& at_rest, const json& moving, const json& speed_share) {
    return json{{"at_rest", at_rest}, {"moving", moving}, {"speed_share", speed_share}};
  };
  const json nothing = estimated(nullptr, nullptr, nullptr);
  now["sources"] = {source("yaw_rate", 0.03, estimated(0.00321, nullptr, nullptr)),
                    source("accel_y", 0.3, estimated(0.0999, 0.9, nullptr)),
                    source("wheel_front_left", 0.05, estimated(nullptr, nullptr, 0.0061)),
                    source("wheel_rear", 0.05, nothing), source("camera", nullptr, nullptr)};
  const std::string text = status_as_text(now, {});
  EXPECT_THAT(text, EndsWith("\n\n"
                             "noise             unit   stated  at rest  moving  of speed\n"
                             "yaw_rate          rad/s  0.0300  0.00321       -         -\n"
                             "accel_y           m/s2    0.300   0.0999   0.900         -\n"
                             "wheel_front_left  m/s    0.0500        -       -    0.61 %\n"));
  for (json& one : now["sources"]) one["noise"] = nothing;
  EXPECT_THAT(status_as_text(now, {}), Not(HasSubstr("noise")));
  for (json& one : now["sources"]) one.erase("noise");  // an older daemon
  EXPECT_THAT(status_as_text(now, {}), Not(HasSubstr("noise")));
}

TEST(StatusText, ShowsWhatAModelHasLearnt) {
  json now = document(10.0, 2000);
  EXPECT_THAT(status_as_text(now, {}), Not(HasSubstr("calibration")));
  now["calibrations"] = {
      {{"name", "gyro_bias"}, {"value", 0.01}, {"sigma", 0.001}, {"valid", true}},
      {{"name", "wheel_scale"}, {"value", 0.985}, {"sigma", 0.03}, {"valid", false}},
      {{"name", "gyro_scale"}, {"value", 1.0}, {"sigma", nullptr}, {"valid", false}},
      {{"name", "wheel_latency"}, {"value", 0.0125}, {"sigma", 0.002}, {"valid", true}},
      {{"name", "grip"}, {"value", 8.5}, {"sigma", 0.25}, {"valid", true}}};
  const std::string text = status_as_text(now, {});
  EXPECT_THAT(text, MatchesRegex("(.|\n)*\ngyro_bias +0.5730  ± 0.0573 deg/s +yes\n(.|\n)*"));
  EXPECT_THAT(text, MatchesRegex("(.|\n)*\nwheel_scale +0.9850  ± 0.0300 +not yet\n(.|\n)*"));
  EXPECT_THAT(text, Not(HasSubstr("gyro_scale")));
  EXPECT_THAT(text, MatchesRegex("(.|\n)*\nwheel_latency +12.5000  ± 2.0000 ms +yes\n(.|\n)*"));
  EXPECT_THAT(text, MatchesRegex("(.|\n)*\ngrip +8.5000  ± 0.2500 m/s2 +yes\n(.|\n)*"));
}

TEST(StatusText, ShowsTheControllersOfThoseBusesThatHaveOne) {
  const std::string text = status_as_text(document(10.0, 2000), {});
  EXPECT_THAT(text, MatchesRegex("(.|\n)*\ncan0  +error-passive, fd  +130  +-  +500000  +0.875  "
                                 "+100 ms  +-  +-  +2  +-\n(.|\n)*"));
  EXPECT_THAT(text, HasSubstr("\ncan0: 5 frames without a hardware stamp\n"));
  json document_of_old = document(10.0, 2000);
  for (auto& bus : document_of_old["can"]) bus.erase("controller");
  EXPECT_THAT(status_as_text(document_of_old, {}), Not(HasSubstr("controller")));
}

TEST(StatusText, TakesRatesFromTheTimeBetweenTwoDocuments) {
  EXPECT_THAT(status_as_text(document(10.5, 2150), document(10.0, 2000)),
              HasSubstr("beat        300.0 Hz"));
  EXPECT_THAT(status_as_text(document(10.0, 2000), {}), HasSubstr("beat        200.0 Hz"));
  json other = document(10.0, 2000);
  other["instance"] = "b2";  // another daemon, with other counts
  EXPECT_THAT(status_as_text(document(0.5, 100), other), HasSubstr("beat        200.0 Hz"));
}

TEST(StatusText, ShowsWhatAnOlderDaemonDoesNotSayAsUnknown) {
  EXPECT_THAT(status_as_text(json::object(), {}), HasSubstr("odomd -, pid -"));
}

TEST(Conditions, HaveANameAndAMeaningForEveryBit) {
  const auto all = conditions_in(0xFFFFFFFFU);
  std::uint32_t bits = 0;
  for (const Condition& condition : all) {
    EXPECT_EQ(condition_named(condition.name)->bit, condition.bit);
    EXPECT_FALSE(condition.meaning.empty());
    EXPECT_THAT(daemon::condition_names(condition.bit), ::testing::ElementsAre(condition.name));
    EXPECT_EQ(bits & condition.bit, 0U);
    bits |= condition.bit;
  }
  EXPECT_EQ(bits, 2U * ODOM_COND_CAMERA_REFUSED - 1U);
}

TEST(Status, PassesTheDocumentOnOrShowsIt) {
  const Scratch scratch;
  const std::string socket = scratch.path("s").string();
  const std::string text = document(10.0, 2000).dump() + "\n";
  const AnsweringSocket daemon{socket, text};
  EXPECT_EQ(run_shell("odom status --json --socket " + socket).out, text);
  EXPECT_THAT(run_shell("odom status --socket " + socket).out, HasSubstr("degraded"));
}

// Deep nesting would exhaust the stack: the JSON library recurses.
TEST(Status, RefusesWhatIsNoStatusOrNestedTooDeep) {
  std::string deep;
  for (int i = 0; i < 200'000; ++i) deep += "{\"a\":";
  deep += '1' + std::string(200'000, '}');
  for (const auto& [answer, says] :
       {std::pair{std::string("{\"mode\":"), "not a status document"}, {deep, ""}}) {
    const Scratch scratch;
    const std::string socket = scratch.path("s").string();
    const AnsweringSocket other_service{socket, answer};
    for (const char* form : {"status --json", "status", "watch --once"}) {
      const Outcome outcome = run_shell(std::string("odom ") + form + " --socket " + socket);
      EXPECT_THAT(outcome, Ends(1, HasSubstr(says))) << form;
      EXPECT_EQ(outcome.out, "") << form;
    }
  }
}

}  // namespace
}  // namespace odomd::tools::status_test
