// Source flags on whole drives: sound drives raise none, failing sensors do.
#include <filesystem>
#include <fstream>
#include <map>
#include <numbers>
#include <optional>
#include <sstream>

#include "tests/recorded_drives.hpp"
#include "tests/tools/monitored_drive.hpp"
#include "tests/tools/scratch.hpp"

namespace odomd::tools::source_flags_test {
namespace {

namespace fs = std::filesystem;
using estimator::Source;
using estimator::SourceFlag;

std::string described(const MonitoredDrive& drive, const FlagChange& change) {
  return std::string{estimator::source_names[static_cast<std::size_t>(change.source)]} + ' ' +
         std::string{estimator::source_flag_names[static_cast<std::size_t>(change.flag)]} + " at " +
         std::to_string(static_cast<double>(change.tick_ns - drive.events.front().tick_ns) * 1e-9);
}

MonitoredDrive simulated(const std::string& options) {
  const Scratch scratch;
  const fs::path drive = simulate(scratch, options);
  return load_drive(daemon::load_config(drive / "car.toml"), drive / "drive.log",
                    drive / "camera.csv");
}

TEST(SourceFlags, RaiseNoAlarmOnSimulatedDrives) {
  for (const std::string_view scenario :
       {"lap", "circle", "slalom", "stop-and-go", "parking", "patch", "road",
        "circle --friction 0.25 --speed 2 --duration 15",
        "slalom --friction 0.15 --speed 3 --duration 6"}) {
    const MonitoredDrive drive = simulated("--scenario " + std::string{scenario} + " --laps 1");
    const bool on_ice = scenario == "patch" || scenario.find("friction") != scenario.npos;
    for (const FlagChange& change : monitored(drive)) {
      // On ice, wheels really slip.
      if (on_ice && (change.flag == SourceFlag::slipping || change.flag == SourceFlag::ok))
        continue;
      ADD_FAILURE() << scenario << ": " << described(drive, change);
    }
  }
}

TEST(SourceFlags, ShowWhatFails) {
  const MonitoredDrive drive = simulated("--scenario lap --seed 3 --laps 2");
  const std::int64_t begin_ns =
      drive.events.front().tick_ns + std::int64_t{12'000'000'000};  // while driving
  int shown = 0;
  for (FaultCase one : fault_cases(drive)) {
    one.fault.begin_ns = begin_ns;
    const MonitoredDrive failed = with_fault(drive, one.fault);
    const auto shown_ns = shown_at(drive, failed, one);
    if (!shown_ns) continue;
    ++shown;
    const std::string what =
        std::string{estimator::source_names[static_cast<std::size_t>(one.fault.source)]} + ' ' +
        std::string{name_of(one.fault.kind)};
    const auto changes = monitored(failed);
    ASSERT_FALSE(changes.empty()) << what;
    EXPECT_EQ(changes.front().source, one.fault.source)
        << what << ": " << described(drive, changes.front());
    EXPECT_GE(changes.front().tick_ns, begin_ns) << what;
    const bool immediate = one.visible == 0.0;
    const std::int64_t period_ns = one.fault.source == Source::camera ? 35'000'000 : 10'000'000;
    EXPECT_LE(changes.front().tick_ns - *shown_ns, immediate ? 3 * period_ns : 505'000'000) << what;
  }
  EXPECT_GE(shown, 18);
}

/// Mean v_x over 0.2 s around a time, from the drive's reference; nothing without a reference.
std::optional<double> true_speed(const fs::path& truth_file, std::int64_t time_ns) {
  std::ifstream file(truth_file);
  std::string line;
  std::vector<std::array<double, 4>> poses;  // t, x, y, yaw
  const double t = static_cast<double>(time_ns) * 1e-9;
  while (std::getline(file, line)) {
    std::array<double, 4> pose{};
    std::ranges::replace(line, ',', ' ');
    std::istringstream fields(line);
    for (double& value : pose) fields >> value;
    if (fields && std::abs(pose[0] - t) <= 0.1) poses.push_back(pose);
  }
  if (poses.size() < 2) return std::nullopt;
  const auto& [t_0, x_0, y_0, yaw_0] = poses.front();
  const auto& [t_1, x_1, y_1, yaw_1] = poses.back();
  const double yaw = yaw_0 + 0.5 * std::remainder(yaw_1 - yaw_0, 2.0 * std::numbers::pi);
  return ((x_1 - x_0) * std::cos(yaw) + (y_1 - y_0) * std::sin(yaw)) / (t_1 - t_0);
}

/// The last value of a source up to a time.
double last_said(const MonitoredDrive& drive, Source source, std::int64_t tick_ns) {
  double value = 0.0;
  for (const auto& event : drive.events) {
    if (event.tick_ns > tick_ns) break;
    if (source_of(event) == source) value = std::get<estimator::Measurement>(event.sample).value;
  }
  return value;
}

TEST(SourceFlags, RaiseNoAlarmOnRecordedDrives) {
  if (!recorded::at_hand(recorded::drives.size())) return;
  std::map<std::string, bool> slipped;
  for (const std::string name : recorded::drives) {
    const fs::path folder = recorded::folder(name);
    for (const bool with_camera : {false, true}) {
      const fs::path camera = folder / "camera.csv";
      if (with_camera && !fs::exists(camera)) continue;
      daemon::Config config = daemon::load_config(recorded::config(name));
      config.can.dbc = {folder / "car.dbc"};
      const MonitoredDrive drive =
          load_drive(config, folder / "drive.log", with_camera ? camera : fs::path{});
      for (const FlagChange& change : monitored(drive)) {
        if (change.flag == SourceFlag::slipping) {
          // The flag is right if the wheel's speed differs from the car's: in a drift or a
          // wheelspin.
          const auto speed = true_speed(folder / "truth.csv", change.tick_ns);
          const double said = last_said(drive, change.source, change.tick_ns);
          slipped[name] = true;
          if (speed && std::abs(said - *speed) > 0.5) continue;
        }
        // The motion capture loses the car for seconds while it drives on. Without camera poses the
        // rear wheel's constant reading looks frozen once, as the car turns in.
        const bool lost = name == "dart_track_v1" && with_camera;
        if (lost && change.source == Source::camera) continue;
        if (lost && change.source == Source::wheel_rear && change.flag == SourceFlag::frozen)
          continue;
        if (change.flag == SourceFlag::ok) continue;
        ADD_FAILURE() << name << (with_camera ? ", with camera: " : ": ")
                      << described(drive, change);
      }
    }
  }
  EXPECT_TRUE(slipped["dart_drift1"]);  // its wheels spin at five times the car's speed
}

}  // namespace
}  // namespace odomd::tools::source_flags_test
