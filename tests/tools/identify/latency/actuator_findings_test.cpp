// Values for [steering], from known responses and from simulated drives.
#include "tests/diagnostics.hpp"
#include "tools/identify/latency/steering_response.hpp"

#include "daemon/core/config.hpp"
#include "tests/gtest.hpp"
#include "tests/tools/scratch.hpp"

namespace odomd::tools::actuator_findings_test {
namespace {

SteeringResponse response(double delay, double lag, double sigma_whole) {
  SteeringResponse s;
  s.dead_time = {delay, 0.012};
  s.time_constant = {lag, 0.012};
  s.in_all = {delay + lag, sigma_whole};
  return s;
}

TEST(ActuatorFindings, AreWrittenWhereDelayAndLagAreSeparable) {
  const auto found = actuator_findings(response(0.064, 0.1, 0.004), {0.004, 0.0}, {});
  ASSERT_EQ(found.values.size(), 2U);
  EXPECT_EQ(found.values[0].key, "steering.delay");
  EXPECT_EQ(found.values[0].determined, Determined::yes);
  EXPECT_NEAR(found.values[0].value, 0.06, 1e-12);  // without the gyro's latency of 4 ms
  EXPECT_EQ(found.values[1].key, "steering.lag");
  EXPECT_EQ(found.values[1].value, 0.1);
  EXPECT_THAT(found.warnings, testing::IsEmpty());
}

TEST(ActuatorFindings, AreNoneOfAMeasuredAngle) {
  const auto found = actuator_findings(response(-0.02, 0.025, 0.004), {}, {});
  for (const Finding& finding : found.values) {
    EXPECT_EQ(finding.determined, Determined::no);
    EXPECT_EQ(finding.key, "");
    EXPECT_THAT(finding.remark, testing::HasSubstr("none visible, 5 +- 4 ms in total"));
  }
  EXPECT_THAT(actuator_findings(response(-0.02, 0.025, 0.004), {}, {.lag_s = 0.1}).warnings,
              testing::ElementsAre(diagnostics::Named("actuator_not_seen", "100 ms")));
}

TEST(ActuatorFindings, AreNotWrittenWhereTheDriveHasTooLittleExcitation) {
  const auto remark = [](const SteeringResponse& s) {
    const auto found = actuator_findings(s, {}, {});
    EXPECT_EQ(found.values[0].determined, Determined::no);
    return found.values[0].remark;
  };
  EXPECT_THAT(remark(response(0.0, 0.03, 0.002)), testing::HasSubstr("together 30 +- 2 ms"));
  EXPECT_THAT(remark(response(0.02, 0.05, 0.02)),
              testing::HasSubstr("70 +- 20 ms in total; drive"));
  EXPECT_THAT(remark(response(0.45, 0.05, 0.04)), testing::HasSubstr("500 +- 40 ms in total"));
  EXPECT_THAT(remark(response(0.6, 0.1, 0.01)), testing::HasSubstr("more than [steering] allows"));
  SteeringResponse failed = response(0.06, 0.1, 0.004);
  failed.failure = "the car does not turn";
  EXPECT_EQ(remark(failed), "the car does not turn");
}

TEST(ActuatorFindings, NeverAreEarly) {
  const auto found = actuator_findings(response(-0.004, 0.2, 0.004), {}, {});
  EXPECT_EQ(found.values[0].determined, Determined::yes);
  EXPECT_EQ(found.values[0].value, 0.0);
  EXPECT_THAT(found.values[0].remark, testing::HasSubstr("measured -4.0 ms"));
}

// The simulated servo, and a drive with a measured steering angle.
TEST(ActuatorFindings, AreTheServoOfACommandAndNoneOfAMeasuredAngle) {
  const Scratch scratch;
  const auto steering_after = [&scratch](const std::string& options) {
    const std::string drive = scratch.path("drive").string();
    must_run("odom sim --force --seed 4 " + options + " --out " + drive);
    must_run("cd " + drive +
             " && odom identify latency --config car.toml --can drive.log --camera camera.csv "
             "--write car.toml");
    return daemon::load_config(drive + "/car.toml").vehicle.steering;
  };
  const estimator::SteeringActuator servo = steering_after("--scenario stop-and-go --servo");
  EXPECT_NEAR(servo.delay_s, 0.06, 0.025);
  EXPECT_NEAR(servo.lag_s, 0.1, 0.025);
  EXPECT_NEAR(servo.delay_s + servo.lag_s, 0.16, 0.008);
  const estimator::SteeringActuator none =
      steering_after("--scenario stop-and-go --steering-commanded 0");
  EXPECT_EQ(none.delay_s, 0.0);
  EXPECT_EQ(none.lag_s, 0.0);
}

}  // namespace
}  // namespace odomd::tools::actuator_findings_test
