// Runs every kind of fault on one simulated drive, with and without camera, and prints a line of
// JSON per run; the first run has no fault. tests/campaign/integrity.py starts it. faults.py starts
// it with --flags: then the sensors of the table in source_flags.hpp fail one at a time, and each
// line contains the source flags.
//
//   fault_runs FOLDER SEED [--kinds a,b,c] [--camera on|off|both] [--list|--flags]
#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <cstdint>
#include <exception>
#include <map>
#include <optional>
#include <random>
#include <ranges>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include <CLI/CLI.hpp>

#include "estimator/common/source.hpp"
#include "tests/campaign/source_flags.hpp"
#include "tools/math/random.hpp"

namespace odomd::campaign {
namespace {

// The default kinds: of each sensor, the faults that differ in how other sensors contradict them;
// one rear and one front wheel represent all wheels.
constexpr std::string_view tried =
    "gyro.frozen,gyro.zero,gyro.stuck,gyro.halved,gyro.doubled,gyro.scaled,gyro.biased,gyro.ramped,"
    "gyro.inverted,gyro.noisy,"
    "accel_x.frozen,accel_x.zero,accel_x.biased,accel_x.inverted,accel_x.noisy,"
    "accel_y.frozen,accel_y.zero,accel_y.biased,accel_y.inverted,accel_y.noisy,"
    "accel.axes_swapped,"
    "steering.frozen,steering.zero,steering.stuck,steering.scaled,steering.biased,steering.ramped,"
    "steering.inverted,steering.noisy,steering.lost,"
    "wheel_rear_left.frozen,wheel_rear_left.zero,wheel_rear_left.halved,wheel_rear_left.doubled,"
    "wheel_rear_left.biased,wheel_rear_left.ramped,wheel_rear_left.noisy,wheel_rear_left.slipping,"
    "wheel_front_right.frozen,wheel_front_right.scaled,wheel_front_right.inverted,"
    "wheel_front_right.locked,"
    "wheels.frozen,wheels.zero,wheels.locked,wheels.halved,wheels.scaled,wheels.inverted,"
    "wheels.lost,wheels.delayed,wheels.left_right,wheels.front_rear,wheels.duplicated,"
    "wheels.reordered,wheels.bit_flips_repaired,"
    "imu.frozen,imu.lost,imu.delayed,imu.jittered,imu.bit_flips,imu.bit_flips_repaired,"
    "bus.jittered,bus.shifted,"
    "camera.lost,camera.frozen,camera.frozen_noisy,camera.moved,camera.turned,camera.drifting,"
    "camera.mirrored,camera.outliers,camera.early,camera.late,camera.noisy,"
    "gyro.one_sided,gyro.rounded,gyro.fading,gyro.frozen_without_camera,gyro.offset_with_steering,"
    "wheels.zero_with_frozen_camera,bus.sagging,camera.skewed,camera.mixed,camera.vague_offset";

// Several faults at once, KIND:BEGIN:LENGTH:SIZE as in odom fault. BEGIN is relative to the start
// of the faults in the run.
constexpr std::array<std::pair<std::string_view, std::string_view>, 6> composed{{
    {"gyro.fading",
     "gyro.scaled:0:20:0.93+gyro.scaled:4:16:0.93+gyro.scaled:8:12:0.93+gyro.scaled:12:8:0.93+"
     "gyro.scaled:16:4:0.93"},
    {"gyro.frozen_without_camera", "gyro.frozen+camera.lost"},
    {"gyro.offset_with_steering", "gyro.biased+steering.biased"},
    {"wheels.zero_with_frozen_camera", "wheels.zero+camera.frozen"},
    {"bus.sagging", "imu.scaled:::0.7+wheels.scaled:::0.7+steering.scaled:::0.7"},
    {"camera.vague_offset", "camera.vague+camera.moved:::2.5"},
}};

// Conditions for a controller, without those of the machine (not_realtime, restarted, carried_over,
// ...), which no replay sets.
constexpr std::uint32_t heeded =
    ODOM_COND_BUS_DOWN | ODOM_COND_SIGNAL_TIMEOUT | ODOM_COND_PROTECTION | ODOM_COND_FRAMES_LOST |
    ODOM_COND_CAMERA_REJECTED | ODOM_COND_MODEL_FAULT | ODOM_COND_NON_FINITE |
    ODOM_COND_SENSOR_FAULT | ODOM_COND_WHEEL_SLIP | ODOM_COND_MISWIRED | ODOM_COND_INCONSISTENT;

constexpr double most_sigmas = 5.0;
constexpr double gross_m = 0.1;
constexpr double gross_rad = 0.1;
constexpr std::uint32_t camera_bit = 1U << estimator::index_of(estimator::Source::camera);

struct Options {
  std::string folder;
  std::uint64_t seed = 1;
  std::string kinds{tried};
  std::string camera = "both";
};

// Whether the mode is that of a good pose: with a camera, tracking, or standstill while the camera
// is healthy; without a camera, dead reckoning or standstill.
bool is_nominal(const Tick& tick, Camera camera) {
  if (camera == Camera::off)
    return tick.mode == ODOM_DEAD_RECKONING || tick.mode == ODOM_STANDSTILL;
  return tick.mode == ODOM_TRACKING ||
         (tick.mode == ODOM_STANDSTILL && (tick.health & camera_bit) != 0);
}

// Whether the pose warns a controller. Bits and a mode that also occur at this tick without the
// fault do not count.
bool is_warned(const Tick& tick, const Tick* healthy, Camera camera) {
  if (!tick.initialised) return true;
  const std::uint32_t routine = healthy != nullptr ? healthy->conditions : 0;
  if ((tick.conditions & heeded & ~routine) != 0) return true;
  if (is_nominal(tick, camera)) return false;
  return healthy == nullptr || healthy->mode != tick.mode;
}

using Json = nlohmann::ordered_json;

double rounded(double value) {
  return std::round(value * 1e4) / 1e4;
}

Json seconds(const Drive& drive, std::optional<std::int64_t> time_ns) {
  return time_ns ? Json(rounded(drive.seconds_at(*time_ns))) : Json(nullptr);
}

// What a controller sees of a run whose first tick has the number `first`. `healthy`: the same
// ticks of the drive without fault; empty if `run` is that drive itself.
Json report_of(const Drive& drive, Camera camera, const Run& run, std::size_t first,
               std::span<const Tick> healthy) {
  const double period_s = static_cast<double>(drive.config.realtime.period_ns) * 1e-9;
  std::size_t silent = 0, gross = 0;
  std::optional<std::int64_t> first_silent, first_gross, detected;
  double worst_m = 0.0;
  for (std::size_t i = 0; i < run.size(); ++i) {
    const Tick& tick = run[i];
    const Tick* const other = healthy.empty() ? nullptr : &healthy[i];
    const std::int64_t now_ns = drive.tick_ns(first + i);
    const auto note = [now_ns](std::optional<std::int64_t>& time_ns) {
      time_ns = time_ns.value_or(now_ns);
    };
    if (is_warned(tick, other, camera)) {
      note(detected);
    } else if (tick.sigmas > most_sigmas) {
      ++silent;
      note(first_silent);
      if (tick.position_m > gross_m || tick.yaw_rad > gross_rad) {
        ++gross;
        note(first_gross);
      }
    }
    worst_m = std::max(worst_m, tick.position_m);
  }
  return {{"silent_s", rounded(static_cast<double>(silent) * period_s)},
          {"silent_gross_s", rounded(static_cast<double>(gross) * period_s)},
          {"first_silent", seconds(drive, first_silent)},
          {"first_gross", seconds(drive, first_gross)},
          {"detected", seconds(drive, detected)},
          {"worst_m", rounded(worst_m)},
          {"end_m", rounded(run.back().position_m)}};
}

void print(Json head, const Json& rest) {
  head.update(rest);
  fmt::print("{}\n", head.dump());
}

std::vector<std::string> split(std::string_view list, char separator) {
  std::vector<std::string> words;
  for (const auto word : std::views::split(list, separator))
    if (!word.empty()) words.emplace_back(word.begin(), word.end());
  return words;
}

struct Trial {
  std::string name;
  std::vector<fault::Fault> faults;
};

std::vector<Trial> trials_of(const std::string& list) {
  std::vector<Trial> trials;
  for (const std::string& name : split(list, ',')) {
    if (name == "none") continue;
    const auto* const found =
        std::ranges::find(composed, name, &decltype(composed)::value_type::first);
    Trial& trial = trials.emplace_back(name);
    for (const std::string& word : split(found != composed.end() ? found->second : name, '+'))
      trial.faults.push_back(fault::parse_fault(word));
  }
  return trials;
}

void run_all(const Drive& drive, Camera camera, const Options& options) {
  // Faults begin after 25 to 60 % of the drive and last 5 s, or, for half of the seeds, to the end.
  sim::RandomStream random(options.seed, "begin of the faults");
  const auto begin =
      static_cast<std::size_t>(random.uniform(0.25, 0.60) * static_cast<double>(drive.ticks));
  const double begin_s = drive.begin_s(begin);
  const bool ends = options.seed / 2 % 2 == 0;
  const FaultyDrive runs(drive, camera, begin);

  const auto print_run = [&](const std::string& kind, Json result, const Tick& left_out) {
    result["left_out_m"] = rounded(left_out.position_m);
    print({{"kind", kind}, {"camera", camera == Camera::on}, {"begin", rounded(begin_s)}}, result);
  };
  print_run("none", report_of(drive, camera, runs.healthy(), 0, {}), runs.healthy().back());

  const std::span healthy = std::span(runs.healthy()).subspan(begin + 1);
  std::map<fault::Sources, Tick> left_out{{0, runs.healthy().back()}};
  for (Trial& trial : trials_of(options.kinds)) {
    fault::Sources sources = 0;
    for (fault::Fault& one : trial.faults) {
      one.begin_s += begin_s;
      one.seed = options.seed;
      if (ends && std::isinf(one.duration_s)) one.duration_s = 5.0;
      sources |= fault::sources_of(one.kind);
    }
    if (sources == camera_bit && camera == Camera::off) continue;
    if (!left_out.contains(sources)) left_out[sources] = runs.without(sources).back();
    print_run(trial.name, report_of(drive, camera, runs.with(trial.faults), begin + 1, healthy),
              left_out[sources]);
  }
}

void print_flags(const Drive& drive, Json head, const std::vector<FlagChange>& changes) {
  Json flags = Json::array();
  for (const FlagChange& change : changes)
    flags.push_back({seconds(drive, change.tick_ns),
                     estimator::source_names[estimator::index_of(change.source)], change.flag});
  print(std::move(head), {{"flags", flags}});
}

// When the source flags report the sensors that fail, one at a time.
void run_flags(const Drive& drive, Camera camera, const Options& options) {
  // The faults begin in the middle half of the drive. The standard fixes the numbers of
  // std::mt19937, but not those of distributions.
  std::mt19937 random(static_cast<unsigned>(options.seed));
  const double share = 0.25 + 0.5 * (static_cast<double>(random()) / 4294967296.0);
  const auto begin = static_cast<std::size_t>(share * static_cast<double>(drive.ticks));
  const FaultyDrive runs(drive, camera, begin);
  print_flags(drive, Json::object(), flag_changes(drive, runs.healthy()));
  for (const FaultCase& one : fault_cases(drive, drive.begin_s(begin))) {
    const fault::Sources sources = fault::sources_of(one.fault.kind);
    if (sources == camera_bit && camera == Camera::off) continue;
    print_flags(
        drive,
        {{"kind", fault::name_of(one.fault.kind)},
         {"source", estimator::source_names[static_cast<std::size_t>(std::countr_zero(sources))]},
         {"begin", rounded(one.fault.begin_s)},
         {"shown", seconds(drive, shown_at(drive, one))}},
        flag_changes(drive, runs.with({&one.fault, 1}), begin + 1, runs.healthy()[begin]));
  }
}

int run(int argc, char** argv) {
  Options options;
  CLI::App app("Every kind of fault on one simulated drive");
  bool list = false, flags = false;
  app.add_option("folder", options.folder, "Drive of odom sim");
  app.add_option("seed", options.seed, "Seed of the faults");
  app.add_option("--kinds", options.kinds, "Kinds, with commas between");
  app.add_option("--camera", options.camera, "on, off, or both")
      ->check(CLI::IsMember({"on", "off", "both"}));
  app.add_flag("--list", list, "The kinds that are tried, a line each");
  app.add_flag("--flags", flags, "Source flags of single faults");
  CLI11_PARSE(app, argc, argv);
  if (list) {
    for (const Trial& trial : trials_of(options.kinds)) fmt::print("{}\n", trial.name);
    return 0;
  }
  const Drive drive = read_drive({.folder = options.folder});
  for (const Camera camera : {Camera::off, Camera::on})
    if (options.camera != (camera == Camera::on ? "off" : "on"))
      (flags ? run_flags : run_all)(drive, camera, options);
  return 0;
}

}  // namespace
}  // namespace odomd::campaign

int main(int argc, char** argv) {
  try {
    return odomd::campaign::run(argc, argv);
  } catch (const std::exception& error) {
    fmt::print(stderr, "fault_runs: {}\n", error.what());
    return 1;
  }
}
