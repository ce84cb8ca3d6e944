// odom status: how it asks for the document and prints it.
#include <optional>
#include <tuple>

#include "tests/tools/own_daemon.hpp"
#include "tests/tools/scratch.hpp"
#include "tools/live/watch/page.hpp"

namespace odomd::tools::status_test {
namespace {

using nlohmann::json;

json document(double uptime, std::uint64_t ticks) {
  json now = json::parse(R"({
    "version": "0.1.0", "instance": "a1", "pid": 42, "config": "car.toml", "shm": "/odomd",
    "model": "paper", "mode": "degraded", "conditions": ["bus_down", "from_the_future"],
    "pose": {"age_s": 0.0021, "x": 1.0, "y": -2.0, "yaw": 0.5, "sigma_x": 0.01, "sigma_y": 0.02,
             "sigma_yaw": 0.0, "reset_count": 1},
    "beat": {"missed": 3},
    "can": [{"name": "can0", "link": "up", "lost": 0, "hardware_fallbacks": 5, "bus_offs": 0,
             "controller": {"state": "error_passive", "restart_ms": 100, "modes": ["fd"],
                            "bit_timing": {"bitrate": 500000, "sample_point": 0.875},
                            "tx_errors": 130, "rx_errors": null, "bus_offs": 2}},
            {"name": "vcan0", "link": "up", "received": 0, "lost": 0, "controller": null}],
    "sources": [{"name": "yaw_rate", "configured": true, "healthy": false, "age_s": null,
                 "last_verdict": "gated", "test_ratio": 1.3, "innovation": [-0.0215],
                 "innovations": {"dimension": 1, "mean_nis": 1.06, "inside_95": 0.943},
                 "verdicts": {"gated": 7}},
                {"name": "motor", "configured": false}]})");
  now["uptime_s"] = uptime;
  now["pose"]["tick"] = now["beat"]["ticks"] = ticks;
  now["can"][0]["received"] = 10 * ticks;
  now["sources"][0]["verdicts"]["fused"] = ticks;
  return now;
}

// What `odom status` prints for the document after changes at some paths, with one blank between
// words, and what it does not print then.
const struct {
  const char* changes;
  std::vector<const char*> says;
  std::vector<const char*> not_then;
} texts[]{
    {"{}",
     {"● degraded it works, but something is missing:", " bus_down a bus is down or gone\n",
      "y -2.000 m ± 0.020 ", " yaw 28.65 ° ± 0.00 ", "forward 0.000 m/s jumps 1\n", " jumps 1\n",
      "beat 200.0 Hz · 2000 ticks · 3 missed · - overruns ", " yaw_rate overdue ",
      " gated 1.30 1.06 94.3 7 gated\n",
      " can0 up, 2000.0 frames/s, 20000 in all, 5 without a hardware stamp\n controller "
      "error-passive, fd, tx 130 rx -, 500 kbit/s at 87.5 %, restart-ms 100, 2 times bus-off\n "
      "vcan0 up"},
     {"motor", "noise", "calibration", "vcan0 up, 0.0 frames/s, 0 in all\n controller"}},
    {R"({"/pose/yaw": 12.3})", {" yaw -15.26 ° ± 0.00 "}, {}},  // without whole turns
    {R"({"/pose": null, "/mode": "initialising"})", {" none yet\n"}, {}},
    {R"({"/mode": "of the future"})", {"unknown mode: is this odom older"}, {}},
    {R"({"": {}})", {" odomd - model - "}, {}},  // an older daemon
    {R"({"/sources/0/flag": "frozen"})", {" yaw_rate frozen "}, {}},
    {R"({"/sources/0/flag": "failed_protection"})", {" yaw_rate failed protection "}, {}},
    {R"({"/sources/0/flag": "drifting"})", {" yaw_rate drifting "}, {}},
    {R"({"/sources/0/healthy": true, "/sources/0/inconsistent": true})",
     {" yaw_rate inconsistent "},
     {}},
    // Wrong wiring is shown unless the values are missing or impossible.
    {R"({"/sources/0/wiring": "left_right_swapped"})", {"miswired: left right swapped"}, {}},
    {R"({"/sources/0/wiring": "sign", "/sources/0/flag": "failed_protection"})", {}, {"miswired:"}},
    {R"({"/sources/0/wiring": "sign", "/sources/0/flag": "out_of_range"})", {}, {"miswired:"}},
    {R"({"/sources/0/wiring": "sign", "/sources/0/flag": "non_finite"})", {}, {"miswired:"}},
    {R"({"/sources/0/wiring": "sign", "/sources/0/flag": "frozen"})", {}, {"miswired:"}},
    {R"({"/sources/0/innovations": null})", {" gated 1.30 7 gated\n"}, {"NIS"}},
    {R"({"/sources/0/innovations": {"dimension": 0, "mean_nis": null}})", {}, {"NIS"}},
    {R"({"/calibrations": [
       {"name": "gyro_bias", "value": 0.01, "sigma": 0.001, "valid": true},
       {"name": "wheel_scale", "value": 0.985, "sigma": 0.03, "valid": false},
       {"name": "gyro_scale", "value": 1.0, "sigma": null, "valid": false},
       {"name": "wheel_latency", "value": 0.0125, "sigma": 0.002, "valid": true},
       {"name": "grip", "value": 8.5, "sigma": 0.25, "valid": true}]})",
     {" gyro_bias 0.5730 ± 0.0573 deg/s learnt\n", " wheel_scale 0.9850 ± 0.0300 not yet\n",
      " wheel_latency 12.5000 ± 2.0000 ms learnt\n", " grip 8.5000 ± 0.2500 m/s2 learnt\n"},
     {"gyro_scale"}},
    {R"({"/sources": [
       {"name": "yaw_rate", "sigma": 0.03, "noise": {"at_rest": 0.00321, "moving": null}},
       {"name": "accel_y", "sigma": 0.3, "noise": {"at_rest": 0.0999, "moving": 0.9}},
       {"name": "wheel_front_left", "sigma": 0.05, "noise": {"speed_share": 0.0061}},
       {"name": "wheel_rear", "sigma": 0.05, "noise": {"speed_share": null}}]})",
     {" source unit stated at rest moving of speed\n yaw_rate rad/s 0.0300 0.00321 - -\n"
      " accel_y m/s2 0.300 0.0999 0.900 -\n wheel_front_left m/s 0.0500 - - 0.61 %\n"},
     {"wheel_rear m/s"}},
    {R"({"/beat": {"ticks": 1, "carried_over": 4, "last_overrun_age_s": 2.0,
                   "last_overrun_execution_us": 6100.0},
         "/realtime": {"priority": 0, "refusals": ["SCHED_FIFO 45: not permitted"]},
         "/clock": {"steps": 2, "suspends": 0}})",
     {", 4 carried over ", " last overrun 2.0 s ago: that tick worked for 6100 µs\n",
      " runs as an ordinary thread, memory not locked, cpu_dma_latency not held, 2 steps of the "
      "wall clock\n refused: SCHED_FIFO 45: not permitted\n"},
     {"suspends"}},
};

TEST(StatusText, ShowsWhatTheDocumentSays) {
  for (const auto& [changes, says, not_then] : texts) {
    json now = document(10.0, 2000);
    const json changed = json::parse(changes);
    for (const auto& [path, value] : changed.items()) now[json::json_pointer(path)] = value;
    const std::string text =
        std::regex_replace(watch::status_as_text(now, {}), std::regex{" +"}, " ");
    for (const char* part : says) EXPECT_THAT(text, HasSubstr(part));
    for (const char* part : not_then) EXPECT_THAT(text, Not(HasSubstr(part)));
  }
}

TEST(StatusText, TakesRatesFromTheTimeBetweenTwoDocuments) {
  const json before = document(10.0, 2000);
  json other = before;
  other["instance"] = "b2";  // another daemon, with other counts
  for (const auto& [now, earlier, rate] :
       {std::tuple{document(10.5, 2150), std::optional{before}, "300.0 Hz"},
        {before, std::nullopt, "200.0 Hz"},
        {document(0.5, 100), std::optional{other}, "200.0 Hz"}})
    EXPECT_THAT(watch::status_as_text(now, earlier), HasSubstr(rate));
}

TEST(Status, PassesTheDocumentOnOrShowsIt) {
  const Scratch scratch;
  const std::string text = document(10.0, 2000).dump() + "\n";
  const AnsweringSocket daemon{scratch.path("s").string(), text};
  EXPECT_EQ(scratch.must_run("odom status --json --socket s"), text);
  EXPECT_THAT(scratch.must_run("odom status --socket s"), HasSubstr("degraded"));
}

// Deep nesting would exhaust the stack: the JSON library recurses.
TEST(Status, RefusesWhatIsNoStatusOrNestedTooDeep) {
  std::string deep;
  for (int i = 0; i < 200'000; ++i) deep += "{\"a\":";
  deep += '1' + std::string(200'000, '}');
  for (const auto& [answer, says] :
       {std::pair{std::string("{\"mode\":"), "not a status document"}, {deep, ""}}) {
    const Scratch scratch;
    const AnsweringSocket other_service{scratch.path("s").string(), answer};
    for (const std::string form : {"status --json", "status", "watch --once"}) {
      const Outcome outcome = scratch.run("odom " + form + " --socket s");
      EXPECT_THAT(outcome, Ends(1, HasSubstr(says))) << form;
      EXPECT_EQ(outcome.out, "") << form;
    }
  }
}

}  // namespace
}  // namespace odomd::tools::status_test
