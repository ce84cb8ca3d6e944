// Reports of housekeeping: CAN controllers, the service manager, the status.
#include <sys/socket.h>
#include <unistd.h>

#include <cstdlib>

#include "daemon/core/conditions.hpp"
#include "daemon/housekeeping/controllers.hpp"
#include "daemon/housekeeping/process_control.hpp"
#include "daemon/housekeeping/status.hpp"
#include "tests/tools/scratch.hpp"
#include "tests/unix_socket.hpp"

namespace odomd::daemon::housekeeping_test {
namespace {

using can::ControllerHealth;

struct Look {
  ControllerHealth health;
  std::string report;  ///< severity and how it begins; empty: none
};

/// Looks at a controller several times.
void expect_reports(can::Controller controller, const std::vector<Look>& looks) {
  ControllerHealth reported = ControllerHealth::error_active;
  for (const auto& [health, expected] : looks) {
    controller.health = health;
    const auto report = report_change(reported, "can0", controller);
    ASSERT_EQ(report.has_value(), !expected.empty()) << expected;
    if (!report) continue;
    EXPECT_THAT((report->severity == Severity::warning ? "warning " : "info ") + report->text,
                StartsWith(expected));
  }
}

TEST(ControllerReports, NameErrorsWithTheFixAndRecoveries) {
  using enum ControllerHealth;
  const std::string off =
      "warning can0: bus-off: the controller has left the bus and receives nothing; ";
  const std::string passive = "warning can0: error-passive: the controller sees too many errors";
  const std::string restarted = "info can0: the controller was restarted after bus-off and is ";
  const std::string active_again = "info can0: the controller is error-active again";
  expect_reports({}, {{stopped, ""}, {error_active, ""}, {error_warning, ""}, {error_active, ""}});
  expect_reports(
      {.errors = can_berr_counter{130, 5}},
      {{error_passive, passive + " (error counters: transmit 130, receive 5); check bit rate"},
       {error_passive, ""},
       {error_warning, ""},
       {error_active, active_again}});
  expect_reports({.restart_ms = 100}, {{bus_off, off + "it restarts after 100 ms"},
                                       {bus_off, ""},
                                       {error_passive, restarted + "error-passive"},
                                       {error_active, active_again}});
  // Down is the link's state, not the controller's.
  expect_reports({.restart_ms = 0},
                 {{bus_off, off + "it does not restart by itself: ip link set can0 down; ip link "
                                  "set can0 type can restart-ms 100"},
                  {stopped, ""},
                  {error_active, restarted + "error-active"}});
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

TEST_F(ServiceManagerTest, GetsWatchdogNotificationsWhileTicksAdvance) {
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

TEST(Conditions, HaveANameAndAMeaningForEveryBit) {
  std::uint32_t bit = 1;
  for (const Condition& condition : conditions) {
    EXPECT_EQ(condition.bit, bit) << condition.name;
    EXPECT_FALSE(condition.meaning.empty()) << condition.name;
    bit *= 2U;
  }
  EXPECT_EQ(bit, 2U * ODOM_COND_CAMERA_REFUSED);
  EXPECT_THAT(condition_names(ODOM_COND_NOT_REALTIME | ODOM_COND_INPUT_ENDED),
              ElementsAre("not_realtime", "input_ended"));
  EXPECT_THAT(condition_names(ODOM_COND_MISWIRED | ODOM_COND_INCONSISTENT |
                              ODOM_COND_BIAS_UNLEARNT | ODOM_COND_SCALE_IMPLAUSIBLE),
              ElementsAre("miswired", "inconsistent", "bias_unlearnt", "scale_implausible"));
}

}  // namespace
}  // namespace odomd::daemon::housekeeping_test
