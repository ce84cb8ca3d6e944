// Log lines about a CAN controller.
#include "daemon/housekeeping/controller_reporter.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace odomd::daemon::controller_reporter_test {
namespace {

using can::ControllerHealth;
using testing::HasSubstr;

/// Checks a controller, every two seconds unless given otherwise.
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

TEST_F(ControllerReporterTest, ReportsTheRecoveryFromBusOff) {
  controller_.restart_ms = 100;
  EXPECT_EQ(
      look(ControllerHealth::bus_off),
      "warning can0: bus-off: the controller has left the bus and receives nothing; it restarts "
      "after 100 ms");
  EXPECT_EQ(look(ControllerHealth::bus_off), "");
  EXPECT_EQ(look(ControllerHealth::error_active),
            "info can0: the controller was restarted after bus-off and is error-active");
}

TEST_F(ControllerReporterTest, SaysHowToRestartAControllerWithoutAutomaticRestart) {
  controller_.restart_ms = 0;
  EXPECT_THAT(look(ControllerHealth::bus_off),
              HasSubstr("ip link set can0 down; ip link set can0 type can restart-ms 100"));
  EXPECT_EQ(look(ControllerHealth::stopped), "") << "down is the link's affair";
  EXPECT_EQ(look(ControllerHealth::error_active),
            "info can0: the controller was restarted after bus-off and is error-active");
}

TEST_F(ControllerReporterTest, ReportsABusOffThatEndedBeforeTheCheck) {
  look(ControllerHealth::error_active, 3);
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

TEST_F(ControllerReporterTest, CountsFromZeroAfterTheInterfaceCameBack) {
  look(ControllerHealth::error_active, 9);
  vanish();
  EXPECT_EQ(look(ControllerHealth::error_active, 0), "");
  EXPECT_THAT(look(ControllerHealth::error_active, 1), HasSubstr("bus-off once and was"));
}

}  // namespace
}  // namespace odomd::daemon::controller_reporter_test
