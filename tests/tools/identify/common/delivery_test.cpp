// What is written into a configuration, and which values there are kept.
#include "tools/identify/common/finding.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <string>

#include "tests/tools/scratch.hpp"
#include "tools/config_patch/config_patch.hpp"

namespace odomd::tools::delivery_test {
namespace {

using testing::AllOf;
using testing::HasSubstr;
using testing::Not;

constexpr auto car = R"([vehicle]
mass = 3.0            # kg (odom identify mass: +- 0.004 kg, scale)
front_axle = 0.175    # m, by hand
rear_axle = 0.085     # m (odom identify fit: +1.0 %)
yaw_inertia = 0.028   # (odom identify inertia: +- 0.0001 kg m2, bifilar pendulum)
cornering_stiffness_front = 20.0
cornering_stiffness_rear = 60.0
track_width = 0.16
[can]
source = "can0"
dbc = "a.dbc"
[can.signals]
wheel_rear = { message = "W", signal = "S", unit = "m/s" }
yaw_rate = { message = "G", signal = "R", unit = "rad/s", sigma = 0.002 } # (sigma: odom identify noise: +- 0.00002 rad/s, standing)
)";

Finding finding(const std::string& key, double value, double sigma) {
  return as_finding(key, key, {value, sigma}, "");
}

Findings findings(const std::string& method, const std::string& origin,
                  std::vector<Finding> values) {
  return {.method = method, .origin = origin, .values = std::move(values)};
}

class DeliveryTest : public testing::Test {
 protected:
  /// What standard error says of them.
  std::string deliver_to_car(const Findings& findings, bool force = false) {
    testing::internal::CaptureStdout();
    testing::internal::CaptureStderr();
    EXPECT_NO_THROW(deliver(findings, {.json = false, .write = car_, .force = force}));
    output_ = testing::internal::GetCapturedStdout();
    return testing::internal::GetCapturedStderr();
  }
  [[nodiscard]] double now(const std::string& key) const { return *number_in(car_, key); }

  const Scratch scratch_;
  const std::string car_ = scratch_.write("car.toml", car).string();
  std::string output_;
};

TEST_F(DeliveryTest, KeepsWhatIsMorePreciseAndWritesTheRest) {
  const Findings fit =
      findings("fit", "60 s of drive",
               {finding("vehicle.mass", 3.02, 0.01), finding("vehicle.front_axle", 0.17, 0.002),
                finding("vehicle.rear_axle", 0.08, 0.002)});
  EXPECT_THAT(deliver_to_car(fit),
              AllOf(HasSubstr("vehicle.mass stays 3 (odom identify mass: +- 0.004 kg, scale), "
                              "which is more precise than 3.02 +- 0.02; --force replaces it"),
                    HasSubstr("2 keys written to " + car_ +
                              ": vehicle.front_axle, vehicle.rear_axle; 1 kept")));
  EXPECT_THAT(output_, HasSubstr("kept: the previous value is more precise (+- 0.004)"));
  EXPECT_EQ(now("vehicle.mass"), 3.0);
  EXPECT_EQ(now("vehicle.front_axle"), 0.17) << "nothing says how precise it was";
  EXPECT_EQ(now("vehicle.rear_axle"), 0.08);

  EXPECT_THAT(deliver_to_car(fit, true), AllOf(HasSubstr("3 keys"), Not(HasSubstr("kept"))));
  EXPECT_EQ(now("vehicle.mass"), 3.02);
}

TEST_F(DeliveryTest, ReplacesWhatIsAsPreciseUpToScatter) {
  const auto weighed = [](double sigma) {
    return findings("mass", "scale", {finding("vehicle.mass", 3.1, sigma)});
  };
  EXPECT_THAT(deliver_to_car(weighed(0.0027)), HasSubstr("its values are more precise"));
  EXPECT_EQ(now("vehicle.mass"), 3.0);
  EXPECT_THAT(deliver_to_car(weighed(0.0025)), HasSubstr("1 key written"));
  EXPECT_EQ(now("vehicle.mass"), 3.1);
}

// A kept curve's stiffness with another curve's grip would be no tyre.
TEST_F(DeliveryTest, ReplacesTogetherWhatMeansSomethingOnlyTogether) {
  const auto measured = [](double sigma_of_grip) {
    return findings("fit", "60 s of drive",
                    {finding("vehicle.cornering_stiffness_front", 21.0, 1.0),
                     finding("vehicle.grip_front", 9.0, sigma_of_grip)});
  };
  Findings precise = measured(0.1);
  precise.values[0].value = 20.5;
  precise.values[0].sigma = 0.1;
  EXPECT_THAT(deliver_to_car(precise), HasSubstr("2 keys written"));
  EXPECT_THAT(deliver_to_car(measured(0.1)), HasSubstr("2 keys written"));
  EXPECT_EQ(now("vehicle.cornering_stiffness_front"), 21.0) << "its grip is as precise as before";
  EXPECT_THAT(deliver_to_car(precise), HasSubstr("2 keys written"));
  EXPECT_THAT(deliver_to_car(measured(1.0)), HasSubstr("its values are more precise"));
  EXPECT_EQ(now("vehicle.cornering_stiffness_front"), 20.5);
}

TEST_F(DeliveryTest, SaysWhatIsAnotherAndWhatContradicts) {
  const auto weighed = [](double value, double sigma) {
    return findings("mass", "scale", {finding("vehicle.mass", value, sigma)});
  };
  EXPECT_THAT(deliver_to_car(weighed(3.01, 0.02)),
              AllOf(HasSubstr("nothing written to " + car_), Not(HasSubstr("contradict"))));
  EXPECT_THAT(deliver_to_car(weighed(3.5, 0.02)),
              AllOf(HasSubstr("they contradict each other"), HasSubstr("measure again")));
  EXPECT_THAT(deliver_to_car(weighed(2985.0, 1.0)),
              AllOf(HasSubstr("vehicle.mass stays 3 "), HasSubstr("[W502]")));
  EXPECT_EQ(contents(car_), car);
  EXPECT_THAT(deliver_to_car(weighed(2985.0, 1.0), true),
              AllOf(HasSubstr("vehicle.mass was 3 and becomes 2985"), HasSubstr("[W501]")));
}

TEST_F(DeliveryTest, ShowsInJsonWhatIsKept) {
  const Findings fit = findings("fit", "60 s of drive", {finding("vehicle.mass", 3.02, 0.01)});
  testing::internal::CaptureStdout();
  testing::internal::CaptureStderr();
  deliver(fit, {.json = true, .write = car_, .force = false});
  static_cast<void>(testing::internal::GetCapturedStderr());
  EXPECT_THAT(testing::internal::GetCapturedStdout(),
              AllOf(HasSubstr("\"code\":\"W502\""), HasSubstr("\"left_as_configured\":true"),
                    HasSubstr("kept: the previous value is more precise (+- 0.00")));
}

TEST_F(DeliveryTest, ReplacesAnotherQuantityHoweverPrecise) {
  const Findings driving =
      findings("noise", "driving", {finding("can.signals.yaw_rate.sigma", 0.01, 0.0005)});
  EXPECT_THAT(deliver_to_car(driving), HasSubstr("1 key written"));
  EXPECT_EQ(now("can.signals.yaw_rate.sigma"), 0.01);
  const auto turned = [](const std::string& method) {
    return findings(method, "", {finding("vehicle.yaw_inertia", 0.03, 0.001)});
  };
  EXPECT_THAT(deliver_to_car(turned("inertia")), HasSubstr("vehicle.yaw_inertia stays 0.028"));
  EXPECT_THAT(deliver_to_car(turned("fit")),
              AllOf(HasSubstr("1 key written"), Not(HasSubstr("stays"))));
  EXPECT_EQ(now("vehicle.yaw_inertia"), 0.03);
}

}  // namespace
}  // namespace odomd::tools::delivery_test
