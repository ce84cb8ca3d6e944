// Source flags on whole drives: sound drives raise none, failing sensors do.
#include "tests/campaign/source_flags.hpp"

#include <map>
#include <set>

#include "tests/recorded_drives.hpp"
#include "tests/tools/scratch.hpp"

namespace odomd::campaign::source_flags_test {
namespace {

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

TEST(SourceFlags, ShowWhatFails) {
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

/// Mean v_x over 0.2 s around a time, from the drive's reference; nothing where that has a gap.
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

}  // namespace
}  // namespace odomd::campaign::source_flags_test
