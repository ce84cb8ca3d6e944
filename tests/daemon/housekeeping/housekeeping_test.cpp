// Reports of housekeeping: CAN controllers, the service manager, the status.
#include <sys/socket.h>
#include <unistd.h>
#include <nlohmann/json.hpp>

#include <cstdlib>
#include <limits>

#include "daemon/housekeeping/controller_reporter.hpp"
#include "daemon/housekeeping/service_manager.hpp"
#include "daemon/housekeeping/status.hpp"
#include "daemon/sockets/json.hpp"
#include "tests/tools/scratch.hpp"
#include "tests/unix_socket.hpp"

namespace odomd::daemon::housekeeping_test {
namespace {

using can::ControllerHealth;

/// Checks a controller at intervals of two seconds, unless given otherwise.
class ControllerReporterTest : public testing::Test {
 protected:
  std::string look(ControllerHealth health, std::uint32_t bus_offs = 0,
                   std::int64_t after_ns = 2'000'000'000) {
    controller_.health = health;
    controller_.statistics = can::ControllerStatistics{};
    controller_.statistics->bus_offs = bus_offs;
    now_ns_ += after_ns;
    const auto said = reporter_.look("can0", controller_, now_ns_);
    return said ? (said->severity == Severity::warning ? "warning " : "info ") + said->text : "";
  }
  void vanish() { EXPECT_FALSE(reporter_.look("can0", std::nullopt, ++now_ns_)); }

  can::Controller controller_;

 private:
  ControllerReporter reporter_;
  std::int64_t now_ns_ = 0;
};

TEST_F(ControllerReporterTest, IsSilentAboutAHealthyController) {
  EXPECT_EQ(look(ControllerHealth::stopped), "");
  EXPECT_EQ(look(ControllerHealth::error_active, 7), "") << "what was before is old";
  EXPECT_EQ(look(ControllerHealth::error_warning, 7), "");
  EXPECT_EQ(look(ControllerHealth::error_active, 7), "");
}

TEST_F(ControllerReporterTest, ReportsErrorPassiveAndTheRecovery) {
  controller_.errors = can::ErrorCounters{130, 5};
  EXPECT_THAT(look(ControllerHealth::error_passive),
              HasSubstr("warning can0: error-passive: the controller sees too many errors (error "
                        "counters: transmit 130, receive 5); check bit rate"));
  EXPECT_EQ(look(ControllerHealth::error_passive), "");
  EXPECT_EQ(look(ControllerHealth::error_warning), "");
  EXPECT_EQ(look(ControllerHealth::error_active),
            "info can0: the controller is error-active again");
}

TEST_F(ControllerReporterTest, ReportsBusOffWithTheWayOutAndTheRecovery) {
  const std::string bus_off =
      "warning can0: bus-off: the controller has left the bus and receives nothing; ";
  const std::string restarted =
      "info can0: the controller was restarted after bus-off and is error-active";
  controller_.restart_ms = 100;
  EXPECT_EQ(look(ControllerHealth::bus_off), bus_off + "it restarts after 100 ms");
  EXPECT_EQ(look(ControllerHealth::bus_off), "");
  EXPECT_EQ(look(ControllerHealth::error_active), restarted);
  controller_.restart_ms = 0;
  EXPECT_THAT(look(ControllerHealth::bus_off),
              HasSubstr("ip link set can0 down; ip link set can0 type can restart-ms 100"));
  EXPECT_EQ(look(ControllerHealth::stopped), "") << "down is the link's affair";
  EXPECT_EQ(look(ControllerHealth::error_active), restarted);
}

TEST_F(ControllerReporterTest, ReportsABusOffThatEndedBeforeTheCheck) {
  look(ControllerHealth::error_active, 9);
  vanish();  // the counters begin at zero when the interface comes back
  EXPECT_EQ(look(ControllerHealth::error_active, 3), "");
  EXPECT_EQ(
      look(ControllerHealth::error_active, 4),
      "warning can0: the controller went bus-off once and was restarted; it is now error-active; "
      "check bit rate, wiring and termination");
  EXPECT_THAT(look(ControllerHealth::error_passive, 6), HasSubstr("bus-off 2 times and was"));
  EXPECT_EQ(look(ControllerHealth::error_active, 6),
            "info can0: the controller is error-active again");
}

TEST_F(ControllerReporterTest, SumsUpWhatHappensMoreThanOnceASecond) {
  constexpr std::int64_t soon_ns = 100'000'000;
  look(ControllerHealth::error_active, 0);
  EXPECT_THAT(look(ControllerHealth::bus_off, 1), HasSubstr("bus-off"));
  EXPECT_EQ(look(ControllerHealth::error_active, 1, soon_ns), "");
  EXPECT_EQ(look(ControllerHealth::bus_off, 2, soon_ns), "");
  EXPECT_EQ(look(ControllerHealth::error_active, 3, soon_ns), "");
  EXPECT_THAT(look(ControllerHealth::error_active, 3),
              HasSubstr("bus-off 2 times more and was restarted; it is now error-active"));
}

class ServiceManagerTest : public testing::Test {
 protected:
  void SetUp() override {
    const auto path = scratch_.path("notify");
    socket_ = ::socket(AF_UNIX, SOCK_DGRAM | SOCK_NONBLOCK | SOCK_CLOEXEC, 0);
    const sockaddr_un address = unix_address(path);
    ASSERT_EQ(::bind(socket_, reinterpret_cast<const sockaddr*>(&address), sizeof address), 0);
    ::setenv("NOTIFY_SOCKET", path.c_str(), 1);
  }
  void TearDown() override {
    ::unsetenv("NOTIFY_SOCKET");
    ::unsetenv("WATCHDOG_USEC");
    ::close(socket_);
  }

  [[nodiscard]] std::string heard() const {
    char text[256];
    const ssize_t size = ::recv(socket_, text, sizeof text, 0);
    return size > 0 ? std::string(text, static_cast<std::size_t>(size)) : "";
  }

  const tools::Scratch scratch_;
  int socket_ = -1;
};

TEST_F(ServiceManagerTest, HearsTheStateOfTheDaemon) {
  notify_ready();
  EXPECT_EQ(heard(), "READY=1");
  notify_status("tracking");
  EXPECT_EQ(heard(), "STATUS=tracking");
  notify_stopping();
  EXPECT_EQ(heard(), "STOPPING=1");
}

TEST_F(ServiceManagerTest, IsFedWhileTheTicksMoveIfItWantsAWatchdog) {
  Watchdog unwanted;
  unwanted.notify(1, 1'000'000'000);
  EXPECT_EQ(heard(), "");
  ::setenv("WATCHDOG_USEC", "300000", 1);  // a notification every 0.1 s
  Watchdog watchdog;
  watchdog.notify(20, 1'000'000'000);
  EXPECT_EQ(heard(), "WATCHDOG=1");
  watchdog.notify(30, 1'050'000'000);
  EXPECT_EQ(heard(), "") << "not yet due";
  watchdog.notify(40, 1'100'000'000);
  EXPECT_EQ(heard(), "WATCHDOG=1");
  watchdog.notify(40, 9'000'000'000);
  EXPECT_EQ(heard(), "") << "a beat that hangs starves it";
  watchdog.notify(41, 9'000'000'001);
  EXPECT_EQ(heard(), "WATCHDOG=1");
}

TEST(Percentile, IsTheUpperEdgeOfItsBucketAndNoMoreThanTheMaximum) {
  std::array<std::uint64_t, ODOM_HISTOGRAM_BUCKETS> histogram{};
  EXPECT_EQ(percentile_us(histogram, 0.5, 0), 0.0);
  histogram[0] = 50;  // below 1 us
  histogram[8] = 49;  // up to 4 us
  histogram[20] = 1;  // up to 32 us
  for (const auto& [share, us] : {std::pair{0.5, 1.0}, {0.51, 4.0}, {0.99, 4.0}, {0.999, 30.0}})
    EXPECT_EQ(percentile_us(histogram, share, 30'000), us) << share;
  histogram = {};
  histogram.back() = 1;
  EXPECT_EQ(percentile_us(histogram, 0.5, 70'000'000), 70'000.0);
}

TEST(ConditionNames, NameEveryBit) {
  EXPECT_THAT(condition_names(ODOM_COND_NOT_REALTIME | ODOM_COND_INPUT_ENDED),
              ElementsAre("not_realtime", "input_ended"));
  EXPECT_THAT(condition_names(ODOM_COND_MISWIRED | ODOM_COND_INCONSISTENT |
                              ODOM_COND_BIAS_UNLEARNT | ODOM_COND_SCALE_IMPLAUSIBLE),
              ElementsAre("miswired", "inconsistent", "bias_unlearnt", "scale_implausible"));
  EXPECT_EQ(condition_names(0xFFFF'FFFF).size(), 20U);
}

TEST(Json, IsReadBackAsItWasWritten) {
  JsonWriter json;
  json.begin_object();
  json.member("text", "a\"b\\c\n\x01");
  json.member("bytes", std::string("\xff\xc3"));
  json.member("number", 0.1);
  json.member("large", std::int64_t{-9'007'199'254'740'993});
  json.member("none", std::numeric_limits<double>::quiet_NaN());
  json.member("yes", true);
  json.begin_array("list");
  json.element(1);
  json.begin_object();
  json.end_object();
  json.element("x");
  json.end_array();
  json.begin_object("inner");
  json.member("a", 1);
  json.member("b", 2);
  json.end_object();
  json.end_object();
  EXPECT_EQ(nlohmann::json::parse(json.text()), nlohmann::json::parse(R"({
      "text": "a\"b\\c\n\u0001", "bytes": "\u00ff\u00c3", "number": 0.1,
      "large": -9007199254740993, "none": null, "yes": true, "list": [1, {}, "x"],
      "inner": {"a": 1, "b": 2}})"));
}

}  // namespace
}  // namespace odomd::daemon::housekeeping_test
