// Source flags and wiring on whole drives: sound drives raise none, failing sensors and mistakes in
// the wiring do, and each mistake is named.
#include <map>
#include <memory>
#include <set>

#include "daemon/core/pipeline.hpp"
#include "tests/campaign/faulty_drive.hpp"
#include "tests/campaign/source_flags.hpp"
#include "tests/diagnostics.hpp"
#include "tests/recorded_drives.hpp"
#include "tests/tools/scratch.hpp"
#include "tools/replay/replay_checks.hpp"
#include "tools/replay/virtual_drive.hpp"

namespace odomd::campaign::source_flags_test {
namespace {

using Names = std::map<std::string, std::string>;

std::string described(const Drive& drive, const FlagChange& change) {
  return std::string(estimator::source_names[estimator::index_of(change.source)]) + ' ' +
         std::string(change.flag) + " at " + std::to_string(drive.seconds_at(change.tick_ns));
}

Drive simulated(const std::string& options) {
  return read_drive({.folder = tools::simulate(tools::Scratch{}, options)});
}

/// No tick has one of these conditions.
void expect_none(std::uint32_t conditions, const Run& run) {
  EXPECT_TRUE(std::ranges::none_of(
      run, [=](const Tick& tick) { return (tick.conditions & conditions) != 0; }));
}

class SoundDrive : public ::testing::TestWithParam<std::string> {};

TEST_P(SoundDrive, RaisesNoAlarm) {
  const Drive drive = simulated(GetParam());
  const bool on_ice = GetParam().find("patch") != std::string::npos ||
                      GetParam().find("friction") != std::string::npos;
  for (const Camera camera : {Camera::off, Camera::on}) {
    const FaultyDrive runs(drive, camera, 0);
    for (const FlagChange& change : flag_changes(drive, runs.healthy())) {
      // On ice, wheels really slip.
      if (on_ice && (change.flag == "slipping" || change.flag == "ok")) continue;
      ADD_FAILURE() << described(drive, change);
    }
    expect_none(ODOM_COND_MISWIRED | ODOM_COND_INCONSISTENT, runs.healthy());
  }
}

INSTANTIATE_TEST_SUITE_P(
    Of, SoundDrive,
    ::testing::Values("--scenario lap", "--scenario circle", "--scenario slalom",
                      "--scenario stop-and-go", "--scenario parking", "--scenario patch",
                      "--scenario patch --speed 2.2", "--scenario exercise --servo",
                      "--scenario road", "--scenario hills", "--car bmw_320i --scenario lap",
                      "--car vw_vanagon --scenario slalom", "--car bmw_320i --scenario parking",
                      "--scenario circle --friction 0.25 --speed 2 --duration 15",
                      "--scenario slalom --friction 0.15 --speed 3 --duration 6"),
    [](const auto& test) { return "Drive" + std::to_string(test.index); });

TEST(SourceFlags, ShowTheFailedSource) {
  const Drive drive = simulated("--scenario lap --seed 3 --laps 2");
  constexpr std::size_t begin = 2400;  // while driving
  const FaultyDrive runs(drive, Camera::on, begin);
  int shown = 0;
  for (const FaultCase& one : fault_cases(drive, drive.begin_s(begin))) {
    const auto shown_ns = shown_at(drive, one);
    if (!shown_ns) continue;
    ++shown;
    SCOPED_TRACE(name_of(one.fault.kind));
    const auto changes =
        flag_changes(drive, runs.with({&one.fault, 1}), begin + 1, runs.healthy()[begin]);
    ASSERT_FALSE(changes.empty());
    EXPECT_TRUE(fault::contains(sources_of(one.fault.kind), changes.front().source))
        << described(drive, changes.front());
    EXPECT_LE(changes.front().tick_ns - *shown_ns, 505'000'000);
  }
  EXPECT_GE(shown, 14);
}

/// Mean v_x over 0.2 s around a time, from the drive's reference; empty in a gap of the reference.
std::optional<double> true_speed(const Drive& drive, std::int64_t time_ns) {
  const auto a = at(*drive.reference, time_ns - 100'000'000),
             b = at(*drive.reference, time_ns + 100'000'000);
  if (!a || !b) return std::nullopt;
  const double yaw = a->pose.yaw + 0.5 * std::remainder(b->pose.yaw - a->pose.yaw, 6.283185307);
  return ((b->pose.x - a->pose.x) * std::cos(yaw) + (b->pose.y - a->pose.y) * std::sin(yaw)) / 0.2;
}

/// The last value of a source up to a time.
double last_said(const Drive& drive, Source source, std::int64_t tick_ns) {
  const fault::CarSignals signals(drive.config.can, drive.databases, drive.buses);
  std::array<fault::Reading, can::max_samples_per_frame> readings{};
  double value = 0.0;
  for (const can::Frame& frame : drive.frames) {
    if (frame.time_ns > tick_ns) break;
    const auto message = signals.message_of(frame);
    const std::size_t count = message ? signals.read(*message, frame, readings) : 0;
    for (std::size_t i = 0; i < count; ++i)
      if (readings[i].source == source) value = readings[i].value;
  }
  return value;
}

// Wiring is checked on the training drives alone.
TEST(SourceFlags, RaiseNoAlarmOnRecordedDrives) {
  const std::set<std::string> training{
      "dart_free1", "dart_slow_steerid", "ini_2026_01_16_01_22_28", "genesis_slow",
      "rav4",       "revs_250lm"};
  if (!recorded::at_hand(recorded::drives.size())) return;
  std::map<std::string, bool> slipped;
  for (const std::string name : recorded::drives) {
    const Drive drive =
        read_drive({.folder = recorded::folder(name), .config = recorded::config(name)});
    for (const Camera camera : {Camera::off, Camera::on}) {
      if (camera == Camera::on && drive.cameras.empty()) continue;
      SCOPED_TRACE(name + (camera == Camera::on ? ", with camera" : ""));
      const FaultyDrive runs(drive, camera, 0);
      if (training.contains(name)) expect_none(ODOM_COND_MISWIRED, runs.healthy());
      for (const FlagChange& change : flag_changes(drive, runs.healthy())) {
        if (change.flag == "slipping") {
          // The flag is right if the wheel's speed differs from the car's: in a drift or a
          // wheelspin.
          const auto speed = true_speed(drive, change.tick_ns);
          slipped[name] = true;
          if (speed && std::abs(last_said(drive, change.source, change.tick_ns) - *speed) > 0.5)
            continue;
        }
        // The motion capture loses the car for seconds while it drives on. Meanwhile the rear
        // wheel's constant reading looks frozen once, as the car turns in.
        const bool lost = name == "dart_track_v1" && camera == Camera::on;
        if (lost && (change.source == Source::camera ||
                     (change.source == Source::wheel_rear && change.flag == "frozen")))
          continue;
        if (change.flag == "ok") continue;
        ADD_FAILURE() << described(drive, change);
      }
    }
  }
  EXPECT_TRUE(slipped["dart_drift1"]);  // its wheels spin at five times the car's speed
}

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

TEST_P(WrongWiring, IsTheOnlyOneNamed) {
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

TEST(WiringMistake, IsReportedInOneLineBeforeAllOthers) {
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
}  // namespace odomd::campaign::source_flags_test
