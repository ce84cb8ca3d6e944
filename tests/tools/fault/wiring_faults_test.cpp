// Mistakes in the wiring, made in simulated drives by odom fault: each is named. In unchanged
// drives source_flags_test.cpp expects none.
#include <map>
#include <memory>

#include "daemon/core/pipeline.hpp"
#include "tests/campaign/faulty_drive.hpp"
#include "tests/diagnostics.hpp"
#include "tests/gtest.hpp"
#include "tests/tools/scratch.hpp"
#include "tools/replay/replay_checks.hpp"
#include "tools/replay/virtual_drive.hpp"

namespace odomd::campaign::wiring_faults_test {
namespace {

/// Findings at any time, by source, and warnings at the end.
struct Found {
  std::map<std::string, std::string> ever;
  std::uint32_t conditions = 0;  ///< at any time
  diagnostics::Diagnostics warnings;
};

Found replayed(const Drive& drive, const std::vector<fault::Fault>& faults, Camera camera) {
  Sent sent = campaign::sent(drive, faults);
  if (camera == Camera::off) sent.cameras.clear();
  const auto pipeline = std::make_unique<daemon::Pipeline>(drive.config, drive.databases,
                                                           drive.buses, camera == Camera::on);
  Found found;
  std::size_t next = 0;
  const tools::ReplaySummary summary = tools::replay(
      *pipeline, drive.config.realtime.period_ns,
      [&] { return next < sent.frames.size() ? &sent.frames[next++] : nullptr; }, sent.cameras,
      [&](const daemon::TickRecord& record) { found.conditions |= record.pose.conditions; });
  for (std::size_t source = 0; source < estimator::source_count; ++source)
    for (std::size_t fault = 1; fault < daemon::wiring_names.size(); ++fault)
      if (summary.wired[source][fault] > 0)
        found.ever[std::string{estimator::source_names[source]}] += daemon::wiring_names[fault];
  found.warnings = tools::check_sources(pipeline->decoder(), summary);
  return found;
}

Drive simulated(const std::string& options) {
  return read_drive({.folder = tools::simulate(tools::Scratch{}, options)});
}

using Names = std::map<std::string, std::string>;
Names all_wheels(const std::string& fault) {
  return {{"wheel_front_left", fault},
          {"wheel_front_right", fault},
          {"wheel_rear_left", fault},
          {"wheel_rear_right", fault}};
}

struct Mistake {
  const char* kind;
  Names names;
};

class WrongWiring : public ::testing::TestWithParam<const char*> {};

TEST_P(WrongWiring, IsNamedAndNothingElseIs) {
  const Drive drive = simulated(GetParam());
  for (const auto& [kind, names] : std::vector<Mistake>{
           {"gyro.inverted", {{"yaw_rate", "sign"}}},
           {"gyro.scaled:::57.3", {{"yaw_rate", "unit"}}},
           {"steering.inverted", {{"steering", "sign"}}},
           {"steering.scaled:::57.3", {{"steering", "unit"}}},
           {"wheels.left_right", all_wheels("left_right_swapped")},
           {"wheels.scaled:::3.6", all_wheels("unit")},
           {"wheel_rear_left.inverted", {{"wheel_rear_left", "sign"}}},
           {"accel_y.inverted", {{"accel_y", "sign"}}},
           {"accel.axes_swapped", {{"accel_x", "axes_swapped"}, {"accel_y", "axes_swapped"}}},
           {"accel.scaled:::0.102", {{"accel_x", "unit"}, {"accel_y", "unit"}}}}) {
    const Found found = replayed(drive, {fault::parse_fault(kind)}, Camera::off);
    EXPECT_EQ(found.ever, names) << kind;
    EXPECT_NE(found.conditions & ODOM_COND_MISWIRED, 0U) << kind;
  }
  for (const auto& [kind, names] : std::vector<Mistake>{{"camera.mirrored", {{"camera", "sign"}}},
                                                        {"wheels.inverted", all_wheels("sign")}}) {
    const Found found = replayed(drive, {fault::parse_fault(kind)}, Camera::on);
    EXPECT_EQ(found.ever, names) << kind;
  }
}

INSTANTIATE_TEST_SUITE_P(Of, WrongWiring,
                         ::testing::Values("--scenario lap", "--scenario slalom",
                                           "--car bmw_320i --scenario lap --laps 1"),
                         [](const auto& test) { return "Drive" + std::to_string(test.index); });

TEST(WiringMistake, OfTheForwardAccelerationShowsWhereItIsBraked) {
  const Drive drive = simulated("--scenario road");
  const Found found = replayed(drive, {fault::parse_fault("accel_x.inverted")}, Camera::off);
  EXPECT_EQ(found.ever, (Names{{"accel_x", "sign"}}));
}

TEST(WiringMistake, IsSaidInOneLineAheadOfAllElse) {
  using diagnostics::Named;
  const Drive drive = simulated("--scenario slalom");
  const auto warnings = [&](const char* kind) {
    return replayed(drive, {fault::parse_fault(kind)}, Camera::off).warnings;
  };
  const auto of_gyro = warnings("gyro.inverted");
  ASSERT_THAT(of_gyro, Not(IsEmpty()));
  EXPECT_THAT(of_gyro[0], Named("wrong_sign", "yaw_rate (IMU)"));
  for (std::size_t i = 1; i < of_gyro.size(); ++i)
    EXPECT_THAT(of_gyro[i].subject, Not(HasSubstr("yaw_rate")));
  const auto of_wheels = warnings("wheels.left_right");
  ASSERT_THAT(of_wheels, Not(IsEmpty()));
  EXPECT_THAT(of_wheels[0],
              Named("left_right_swapped", "wheel_rear_left (WHEELS_REAR), wheel_rear_right"));
  for (std::size_t i = 1; i < of_wheels.size(); ++i)
    EXPECT_THAT(of_wheels[i].subject, Not(HasSubstr("wheel_")));
}

TEST(ScatteringSource, BringsTheCondition) {
  const Drive drive = simulated("--scenario lap --laps 1");
  const Found found = replayed(drive, {fault::parse_fault("wheels.noisy")}, Camera::off);
  EXPECT_NE(found.conditions & ODOM_COND_INCONSISTENT, 0U);
  EXPECT_EQ(found.conditions & ODOM_COND_MISWIRED, 0U);
}

}  // namespace
}  // namespace odomd::campaign::wiring_faults_test
