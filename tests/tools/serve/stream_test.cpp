// What odom serve says about a daemon: its stream of events and its metrics.
#include "tests/tools/own_daemon.hpp"
#include "tests/tools/serve/serve_process.hpp"

namespace odomd::tools::stream_test {
namespace {

const char* const status_text = R"({"version": "0.1.0", "instance": "1", "uptime_s": 5.5,
  "mode": "tracking", "conditions": ["sensor_fault", "restarted"],
  "pose": {"vx": 1.5, "reset_count": 2, "sigma_x": null},
  "beat": {"ticks": 1000, "missed": 1, "overruns": 0, "wakeup_us": {"p50": 12.5, "max": 900.0}},
  "can": [{"name": "can\"0\\\n", "link": "up", "received": 7, "lost": 0}],
  "sources": [{"name": "camera", "configured": true, "healthy": false, "flag": "frozen", "age_s": 1.5,
    "verdicts": {"fused": 3, "gated": 1}, "innovations": {"mean_nis": 2.5, "dimension": 3}},
    {"name": "motor", "configured": false, "healthy": false, "verdicts": {}}]})";

std::vector<long> ids_in(const std::string& stream) {
  std::vector<long> ids;
  for (std::size_t at = 0; (at = stream.find("\nid: ", at)) != std::string::npos; at += 5)
    ids.push_back(std::stol(stream.substr(at + 5)));
  return ids;
}

TEST_F(Serve, FiftyViewersOfWhomTenAreStalled) {
  SlowDaemon daemon{segment()};
  const AnsweringSocket status{scratch_.path("status.sock").string(), status_text};
  daemon.tick();
  start();
  const long before_kb = resident_kb();
  std::vector<Client> viewers;
  const auto add_viewer = [&](int receive_buffer) -> Client& {
    viewers.emplace_back(port_, receive_buffer)
        .send("GET /events HTTP/1.1\r\nHost: localhost\r\n\r\n");
    return viewers.back();
  };
  for (int i = 0; i < 10; ++i) add_viewer(2048);
  for (int i = 10; i < 64; ++i)
    ASSERT_THAT(add_viewer(0).receive("\n\n"), StartsWith("HTTP/1.1 200"));
  EXPECT_EQ(code("/events"), "503");
  EXPECT_EQ(code("/"), "200");
  viewers.erase(viewers.begin() + 50, viewers.end());
  const auto end = steady_clock::now() + milliseconds{12'000};
  while (steady_clock::now() < end) {
    for (std::size_t i = 10; i < viewers.size(); ++i) viewers[i].receive("\xff", MSG_DONTWAIT);
    std::this_thread::sleep_for(milliseconds{100});
  }
  for (std::size_t i = 10; i < viewers.size(); ++i) {
    const std::vector<long> ids = ids_in(viewers[i].receive("\xff", MSG_DONTWAIT));
    ASSERT_GT(ids.size(), 150U);
    for (std::size_t k = 1; k < ids.size(); ++k) ASSERT_EQ(ids[k], ids[k - 1] + 1) << i;
  }
  EXPECT_LT(resident_kb() - before_kb, 8000);
  // The stalled viewers were dropped: their places are free.
  for (int i = 0; i < 24; ++i)
    EXPECT_THAT(add_viewer(0).receive("\n\n"), StartsWith("HTTP/1.1 200")) << i;
  EXPECT_EQ(server_->terminate().status, 0);
}

TEST_F(Serve, FollowsADaemonThatComesGoesAndIsReplaced) {
  start();
  EXPECT_THAT(stream_until("WAITING"), HasSubstr("WAITING"));
  EXPECT_THAT(get("/metrics"), HasSubstr("\nodom_up 0\n# EOF\n"));
  auto daemon = std::make_unique<SlowDaemon>(segment(), 50'000'000);
  daemon->pose.x = 1.25;
  daemon->tick();
  EXPECT_THAT(stream_until("\"live\":true"), HasSubstr("1.2500"));
  EXPECT_THAT(stream_until("SILENT"), HasSubstr("\"live\":false"));
  daemon.reset();
  daemon = std::make_unique<SlowDaemon>(segment());
  daemon->pose.x = 7.5;
  daemon->tick();
  EXPECT_THAT(stream_until("7.5000"),
              HasSubstr(",2.0000,7.5000,"));  // a new section of the trail
  EXPECT_THAT(stream_until("has restarted"), HasSubstr("odomd has restarted 1 time meanwhile"));
}

TEST_F(Serve, SaysThatASegmentHasAnotherAbi) {
  std::ofstream(segment(), std::ios::binary) << std::string(4096, 'x');
  start();
  EXPECT_THAT(stream_until("ABI"), HasSubstr("ABI"));
}

TEST_F(Serve, MapsNothingOfTheSegmentWritable) {
  SlowDaemon daemon{segment()};
  daemon.tick();
  start();
  ASSERT_THAT(stream_until("tracking"), HasSubstr("tracking"));
  std::istringstream maps{proc("maps")};
  int found = 0;
  for (std::string line; std::getline(maps, line);) {
    if (line.find(segment()) != std::string::npos) {
      ++found;
      EXPECT_THAT(line, HasSubstr(" r--s "));
    } else if (line.find(" rw-s ") != std::string::npos) {
      ADD_FAILURE() << "shared and writable: " << line;
    }
  }
  EXPECT_GT(found, 0);
}

// tests/campaign/serve.sh gives these metrics to Prometheus' own parsers.
TEST_F(Serve, GivesTheMetricsOfOdomStatus) {
  const AnsweringSocket status{scratch_.path("status.sock").string(), status_text};
  start();
  const std::string socket = " --socket " + scratch_.path("status.sock").string();
  const Outcome printed = run_shell("odom status --openmetrics" + socket);
  EXPECT_THAT(printed, Ends(0, IsEmpty()));
  EXPECT_TRUE(printed.out.ends_with("\n# EOF\n"));
  for (const char* line :
       {"odom_up 1\n", "odom_mode{mode=\"tracking\"} 1\n", "odom_ticks_total 1000\n",
        "odom_condition{condition=\"sensor_fault\"} 1\n", "odom_pose_jumps_total 2\n",
        "odom_tick_lateness_seconds{statistic=\"max\"} 0.0009\n",
        "odom_can_frames_total{bus=\"can\\\"0\\\\\\n\"} 7\n",
        "odom_source_healthy{source=\"camera\"} 0\n",
        "odom_source_samples_total{source=\"camera\",verdict=\"gated\"} 1\n"})
    EXPECT_THAT(printed.out, HasSubstr(line));
  EXPECT_THAT(printed.out, AllOf(Not(HasSubstr("motor")), Not(HasSubstr("sigma_x"))));
  ASSERT_TRUE(eventually([&] { return get("/metrics").ends_with(printed.out); }));
  EXPECT_THAT(get("/metrics"), HasSubstr("application/openmetrics-text; version=1.0.0"));
  EXPECT_THAT(stream_until("frozen"), HasSubstr(R"(["camera","frozen",false,)"));
}

TEST(OpenMetrics, WithoutADaemonSaysSo) {
  const Outcome printed = run_shell("odom status --openmetrics --socket nowhere.sock");
  EXPECT_THAT(printed, Ends(0, HasSubstr("nowhere.sock: no such socket")));
  EXPECT_THAT(printed.out, HasSubstr("\nodom_up 0\n# EOF\n"));
}

TEST_F(Serve, SaysThatAStatusIsNotUnderstood) {
  const AnsweringSocket status{scratch_.path("status.sock").string(),
                               R"({"sources": [{"name": "motor", "configured": "maybe"}]})"};
  start();
  EXPECT_THAT(stream_until("same version"), HasSubstr("the status cannot be parsed"));
}

}  // namespace
}  // namespace odomd::tools::stream_test
