// odom watch: the lines and parts of its pages about a daemon, and its keys.
#include <limits>
#include <nlohmann/json.hpp>

#include "daemon/core/conditions.hpp"
#include "tests/gtest.hpp"
#include "tools/live/line.hpp"
#include "tools/live/watch/page.hpp"
#include "tools/live/watch/terminal.hpp"

namespace odomd::tools::watch::watch_test {
namespace {

using nlohmann::json;

constexpr std::int64_t ms = 1'000'000;
constexpr std::int64_t s = 1000 * ms;

// The pose of a car on a left circle of 2 m radius at 1.5 m/s.
odom_pose pose_at(double seconds) {
  const double angle = 0.75 * seconds;
  odom_pose pose{};
  pose.tick = static_cast<std::uint64_t>(200.0 * seconds);
  pose.time_ns = 1000 * s + static_cast<std::int64_t>(seconds * 1e9);
  pose.x = 2.0 * std::sin(angle);
  pose.y = 2.0 - 2.0 * std::cos(angle);
  pose.yaw = angle;
  pose.vx = 1.5;
  pose.yaw_rate = 0.75;
  pose.steering = 0.125;
  pose.mode = ODOM_TRACKING;
  pose.covariance[0] = 0.01 * 0.01;
  pose.covariance[3] = 0.02 * 0.02;
  pose.covariance[5] = 0.01 * 0.01;
  return pose;
}

json document(double uptime) {
  const auto n = static_cast<std::uint64_t>(100.0 * uptime);
  json now = json::parse(R"({
    "instance": "0000000000000001", "config": "/etc/odomd/car.toml",
    "beat": {"missed": 3, "overruns": 0,
             "wakeup_us": {"p50": 12.3, "p99": 50.0, "p999": 120.0, "max": 6799.0},
             "execution_us": {"p50": 4.0, "p99": 8.0, "p999": 9.5, "max": 31.0}},
    "realtime": {"priority": 45, "cpu": -1, "memory_locked": true, "dma_latency_held": false},
    "can": [{"name": "can0", "link": "up", "lost": 2, "error_frames": 0, "malformed": 0,
             "link_downs": 1,
             "controller": {"state": "error_passive", "tx_errors": 0, "rx_errors": 130,
                            "restart_ms": 100,
                            "bit_timing": {"bitrate": 500000, "sample_point": 0.875}}}],
    "sources": [{"name": "yaw_rate", "configured": true, "healthy": true, "age_s": 0.0031,
                 "last_verdict": "fused", "test_ratio": null,
                 "verdicts": {"gated": 0, "source_off": 0}},
                {"name": "motor", "configured": false},
                {"name": "steering", "configured": true, "healthy": false, "age_s": null,
                 "last_verdict": "none", "test_ratio": null,
                 "verdicts": {"fused": 0, "gated": 0, "source_off": 0}},
                {"name": "camera", "configured": true, "healthy": true, "age_s": 0.041,
                 "last_verdict": "gated", "test_ratio": 1.3,
                 "verdicts": {"gated": 7, "source_off": 0}}],
    "camera": {"socket": "/run/odomd/camera.sock", "malformed": 1, "last_latency_s": 0.0352,
               "connections": [{"pid": 7}]},
    "messages": [{"name": "IMU", "id": 418, "age_s": 0.003, "some_lost": 1,
                  "verdicts": {"unmapped": 0, "failed_crc": 3}}]})");
  now["uptime_s"] = uptime;
  now["beat"]["ticks"] = 2 * n;
  now["can"][0]["received"] = 5 * n;
  now["sources"][0]["verdicts"]["fused"] = n;
  now["sources"][3]["verdicts"]["fused"] = n / 4;
  now["camera"]["messages"] = n / 4 + 7;
  now["messages"][0]["verdicts"]["decoded"] = n;
  return now;
}

State driving() {
  State state;
  state.now_ns = 1006 * s + 2 * ms;
  state.segment_name = "/odomd";
  state.socket = "/run/odomd/status.sock";
  for (int i = 0; i <= 120; ++i) state.trail.take(pose_at(0.05 * i), 1);
  Segment segment;
  segment.pose = pose_at(6.0);
  segment.details.velocity_covariance[9] = 0.02 * 0.02;
  segment.info.instance_id = 1;
  segment.info.writer_pid = 4242;
  segment.info.writer_start_ns = 990 * s;
  std::strcpy(segment.info.model, "paper");
  std::strcpy(segment.info.version, "0.1.0");
  state.segment = segment;
  state.status = document(12.0);
  state.before = document(10.0);
  return state;
}

std::string screen_of(const State& state, const View& view) {
  return '\n' + as_text(screen(draw(state, view), view));
}

TEST(Watch, DrawsADaemonOnAnOrdinaryTerminal) {
  EXPECT_EQ(screen_of(driving(), {.rows = 30}), R"(
 odomd 0.1.0  model paper  /etc/odomd/car.toml              pid 4242  up 16.0 s
 ● tracking  camera poses are coming in
── pose  tick 1200 · 2.0 ms old ────────────────────────────────────────────────
  x            -1.955 m     ± 0.010
  y             2.422 m     ± 0.020                       ⢀⣀⣀⣀⣀
  yaw         -102.17 °     ± 0.57                      ⡤⠚⠉    ⠉⠓⢤⡀
  3σ         6.0 × 3.0 cm at 90 °                     ⢀⠎          ⠳⡀
  forward       1.500 m/s   ± 0.020                   ↓            ⢣
  to left       0.000 m/s   ± 0.000                                ⢸
  yaw rate      42.97 °/s   ± 0.00                                ⢠⠇
  steering       7.16 °                                         ⢀⡴⠋
  jumps      0                                               ⠖⠒⠊⠁
                                           ├─────┤ 2 m
── sources ─────────────────────────────────────────────────────────────────────
  source    state      1/s      age  fused  last        not fused
  yaw_rate  fine     100.0   3.1 ms   1200  fused
  steering  overdue    0.0    never      0  none
  camera    fine      25.0  41.0 ms    300  gated 1.30  7 gated
── beat  200.0 Hz · 2400 ticks · 3 missed · 0 overruns ─────────────────────────
  wake-up late by   median 12  99 % 50  99.9 % 120  max 6799 µs
  a tick works for  median 4.0  99 % 8.0  99.9 % 9.5  max 31 µs
  runs as SCHED_FIFO 45, memory locked, cpu_dma_latency not held
── camera  /run/odomd/camera.sock ──────────────────────────────────────────────
  25.0 poses/s, the last one 35.2 ms late, 1 connection, 1 malformed
── bus ─────────────────────────────────────────────────────────────────────────
  can0 up, 500.0 frames/s, 6000 in all, 2 lost, 1 times down
    controller error-passive, tx 0 rx 130, 500 kbit/s at 87.5 %, restart-ms 100
── messages ────────────────────────────────────────────────────────────────────
  message  id       1/s     age  decoded  refused
 q quit  p pause  ↑↓ scroll                                  1 more lines below
)");
}

// All roles of a car, and a camera, in 24 rows.
TEST(Watch, ShowsAllSourcesOnASmallTerminal) {
  State state = driving();
  json& sources = (*state.status)["sources"];
  for (const char* name : {"accel_x", "accel_y", "wheel_front_left", "wheel_front_right",
                           "wheel_rear_left", "wheel_rear_right"}) {
    sources.push_back(sources[0]);
    sources.back()["name"] = name;
  }
  state.segment->pose.mode = ODOM_DEGRADED;
  state.segment->pose.conditions = ODOM_COND_BUS_DOWN;
  EXPECT_THAT(screen_of(state, {}), testing::StartsWith(R"(
 odomd 0.1.0  model paper  /etc/odomd/car.toml              pid 4242  up 16.0 s
 ● degraded  it works, but something is missing:
   bus_down  a bus is down or gone
── pose  tick 1200 · 2.0 ms old ────────────────────────────────────────────────
  x            -1.955 m     ± 0.010       forward       1.500 m/s   ± 0.020
  y             2.422 m     ± 0.020       to left       0.000 m/s   ± 0.000
  yaw         -102.17 °     ± 0.57        yaw rate      42.97 °/s   ± 0.00
  3σ         6.0 × 3.0 cm at 90 °         steering       7.16 °
                                          jumps      0
── sources ─────────────────────────────────────────────────────────────────────
  source             state      1/s      age  fused  last        not fused
)"));
  EXPECT_THAT(screen_of(state, {}), HasSubstr("  wheel_rear_right   fine"));
}

TEST(Watch, KeepsTheTextOfAConditionOnANarrowTerminal) {
  State state = driving();
  state.segment->pose.mode = ODOM_DEGRADED;
  state.segment->pose.conditions = 0x1FFF;
  std::string text = screen_of(state, {.columns = 60, .rows = 60});
  std::erase(text, '\n');
  for (std::size_t at = 0; (at = text.find("  ", at)) != std::string::npos;) text.erase(at, 1);
  for (const daemon::Condition& condition : daemon::conditions_in(0x1FFF))
    EXPECT_THAT(text,
                HasSubstr(std::string{condition.name} + " " + std::string{condition.meaning}));
}

TEST(Watch, ShowsInnovationsWhereThereIsRoom) {
  State state = driving();
  (*state.status)["sources"][0]["innovations"] = {
      {"count", 100}, {"dimension", 1}, {"mean_nis", 1.06}, {"inside_95", 0.943}};
  const std::string roomy = screen_of(state, {.columns = 100, .rows = 60});
  EXPECT_THAT(roomy, HasSubstr("last         NIS  in 95 %  not fused\n"));
  EXPECT_THAT(roomy, HasSubstr("fused       1.06     94.3\n"));
  EXPECT_THAT(screen_of(state, {.columns = 80, .rows = 60}), Not(HasSubstr("NIS")));
}

TEST(Watch, FillsAScreenOfAnySizeExactly) {
  State degraded = driving();
  degraded.segment->pose.conditions = 0x1FFF;
  for (const State& state : {driving(), State{}, degraded}) {
    for (const std::size_t columns : {1U, 20U, 63U, 64U, 80U, 111U, 155U, 156U, 300U}) {
      for (const std::size_t rows : {1U, 2U, 5U, 24U, 34U, 44U, 200U}) {
        const View view{.columns = columns, .rows = rows, .scrolled = 1000};
        const Lines lines = screen(draw(state, view), view);
        ASSERT_EQ(lines.size(), rows);
        for (const Line& line : lines) ASSERT_EQ(width(line), columns) << as_text(line);
      }
    }
  }
}

TEST(Watch, ScrollsToTheEndAndNoFurther) {
  View view{.rows = 18};
  const Picture picture = draw(driving(), view);
  const std::size_t most = most_scrolled(picture, view);
  EXPECT_EQ(picture.head.size() + picture.body.size() + 1, view.rows + most);
  view.scrolled = most + 5;
  const std::string end = as_text(screen(picture, view));
  EXPECT_THAT(end, AllOf(HasSubstr("tracking"), HasSubstr("IMU"), HasSubstr("the end")));
}

// What the page says about a daemon in another state.
TEST(Watch, SaysWhatIsMissing) {
  const struct {
    void (*change)(State&);
    const char* says;
  } cases[]{
      {[](State& state) {
         state = {};
         state.segment_name = "/odomd, /run/odomd/pose";
         state.segment_problem = "no such segment: is odomd running?";
       },
       "WAITING  for odomd at /odomd, /run/odomd/pose\n   no such segment: is odomd running?\n"},
      {[](State& state) { state.status_problem = "status.sock: no such socket"; },
       "status.sock: no such socket"},
      {[](State& state) {
         state.segment->silent = true;
         state.segment->beat.heartbeat_ns = state.now_ns - 3 * s;
       },
       "SILENT  no tick for 3.0 s; waiting for odomd at"},
      {[](State& state) { state.restarts = 1; }, "odomd has restarted 1 time meanwhile"},
      {[](State& state) { state.segment->info.instance_id = 2; },
       "belongs to another daemon than the pose"},
      {[](State& state) { state.segment->pose.mode = ODOM_INITIALISING; }, "none yet"},
      {[](State& state) {
         state.status =
             json{{"sources", {{{"configured", "yes"}}}}, {"can", 7}, {"beat", {{"ticks", "x"}}}};
       },
       "are odom and odomd of the same version?"}};
  for (const auto& [change, says] : cases) {
    State state = driving();
    change(state);
    EXPECT_THAT(screen_of(state, {}), HasSubstr(says));
  }
  State state = driving();
  state.status = json::object();
  EXPECT_THAT(screen_of(state, {}), Not(HasSubstr("of the same version")));
}

odom_pose pose_at_place(double x, double y) {
  odom_pose pose{};
  pose.x = x;
  pose.y = y;
  pose.mode = ODOM_TRACKING;
  return pose;
}

TEST(WatchMap, DrawsWhatIsNotFiniteOrHugeWithoutHarm) {
  constexpr double inf = std::numeric_limits<double>::infinity();
  const Trail trail;
  for (const double value : {inf, -inf, 1e300, -1e300, std::nan("")}) {
    odom_pose pose = pose_at_place(1.0, 1.0);
    pose.covariance[0] = value;
    EXPECT_EQ(draw_map(trail, pose, 30, 8).size(), 8U);
    pose.x = value;
    EXPECT_EQ(draw_map(trail, pose, 30, 8).size(), 8U);
  }
}

TEST(WatchMap, StandsStillWhileTheCarMovesALittle) {
  Trail trail;
  for (int i = 0; i <= 120; ++i) trail.take(pose_at_place(0.02 * i, 0.05 * i), 1);
  const auto scale_of = [&trail](double y) {
    return as_text(draw_map(trail, pose_at_place(1.2, y), 40, 10).back());
  };
  EXPECT_EQ(scale_of(3.0), scale_of(3.3));
}

TEST(WatchMap, GivesTheAxesOfAnEllipse) {
  const Ellipse flat = ellipse_of({0.04, 0.0, 0.01}, 3.0);
  EXPECT_NEAR(flat.long_half_axis, 0.6, 1e-12);
  EXPECT_NEAR(flat.short_half_axis, 0.3, 1e-12);
  EXPECT_NEAR(flat.direction, 0.0, 1e-12);
  EXPECT_NEAR(ellipse_of({0.02, 0.01, 0.02}, 1.0).direction, std::atan(1.0), 1e-12);
  EXPECT_NEAR(ellipse_of({0.01, 0.0, 0.04}, 1.0).direction, 2.0 * std::atan(1.0), 1e-12);
}

TEST(WatchTrail, KeepsTheDriveWhileTheCarStandsAndBreaksAtALeap) {
  Trail trail;
  odom_pose pose = pose_at_place(0.0, 0.0);
  trail.take(pose, 1);
  trail.take(pose, 1);
  EXPECT_EQ(trail.points().size(), 1U);
  pose.x += 1.0;
  trail.take(pose, 1);
  pose.x += 5.0;
  pose.jump_x = 5.0;
  pose.reset_count = 1;
  trail.take(pose, 1);
  pose.x += 5.0;
  trail.take(pose, 2);  // another daemon
  std::vector<bool> joined;
  for (const TrailPoint& point : trail.points()) joined.push_back(point.joined);
  EXPECT_THAT(joined, ElementsAre(false, true, false, false));
  for (int i = 0; i < 2000; ++i) {
    pose.x += 0.01;
    trail.take(pose, 2);
  }
  EXPECT_EQ(trail.points().size(), Trail::longest);
}

TEST(WatchLine, IsCutAndFilledByCharacters) {
  const Line line{{"±12", Style::strong}, {"°C"}};
  EXPECT_EQ(as_text(fitted(line, 4)), "±12°");
  EXPECT_EQ(width(fitted(line, 9)), 9U);
  EXPECT_EQ(as_text(justified({{"left"}}, {{"right"}}, 12)), "left   right");
  EXPECT_EQ(as_text(justified({{"left"}}, {{"right"}}, 10)), "left");
}

TEST(WatchLine, HasColoursOnlyWhereTheyAreWanted) {
  const Line line{{"a", Style::good}, {"b"}, {"c", Style::bad}};
  EXPECT_EQ(as_ansi(line, Colour::on), "\x1b[32ma\x1b[0mb\x1b[1;31mc\x1b[0m");
  EXPECT_EQ(as_ansi(line, Colour::off), "ab\x1b[1mc\x1b[0m");
}

TEST(WatchKeys, AreReadFromWhatATerminalSends) {
  EXPECT_THAT(keys_in("pq ?"), ElementsAre(Key::pause, Key::quit, Key::pause));
  EXPECT_THAT(keys_in("\x1b[A\x1bOB\x1b[5~\x1b[6~"),
              ElementsAre(Key::up, Key::down, Key::page_up, Key::page_down));
  EXPECT_THAT(keys_in("\x1b[1;5C\x1b[200~x\x1b"), IsEmpty());
  EXPECT_THAT(keys_in("\x1b["), IsEmpty());
}

}  // namespace
}  // namespace odomd::tools::watch::watch_test
