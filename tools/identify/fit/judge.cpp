#include "tools/identify/fit/judge.hpp"

#include <algorithm>
#include <stdexcept>
#include <utility>

#include "can_protocol/bus_names.hpp"
#include "can_protocol/sources/log_reader.hpp"
#include "tools/evaluation/drive_evaluation.hpp"
#include "tools/identify/fit/drive.hpp"
#include "tools/identify/fit/reference.hpp"

namespace odomd::tools::fitting {
namespace {

constexpr std::array goals{Goal::prediction, Goal::second, Goal::position, Goal::heading};
constexpr double part_s = 8.0;         // of a 1:10 car
constexpr std::size_t most_parts = 8;  // of a drive

/// The path of the centre of gravity, whole and in parts.
std::vector<Trajectory> parts_of(const Trajectory& reference, const estimator::Pose2& arm,
                                 double slow) {
  const Trajectory whole = at_centre_of_gravity(reference, arm);
  const std::int64_t first = whole.points.front().t_ns, last = whole.points.back().t_ns;
  const auto count = static_cast<std::int64_t>(
      std::clamp(1e-9 * static_cast<double>(last - first) / (part_s * slow), 2.0,
                 static_cast<double>(most_parts)));
  std::vector<Trajectory> parts{whole};
  for (std::int64_t k = 0; k < count; ++k)
    parts.push_back(cut_to(whole, first + k * ((last - first) / count),
                           first + (k + 1) * ((last - first) / count)));
  return parts;
}

}  // namespace

tools::Drive trial_drive(const std::string& name, const daemon::Config& config,
                         std::span<const std::string> logs,
                         std::vector<estimator::CameraPose> poses, double from, double to) {
  tools::Drive drive;
  drive.name = name;
  drive.folder = name;
  drive.config = config;
  drive.databases = daemon::load_databases(drive.config, drive.warnings);
  can::BusNames buses;
  for (const std::string& bus : daemon::expected_buses(drive.config)) buses.index_of(bus);
  can::MergedLog log(logs, buses);
  std::int64_t first = 0, last = std::numeric_limits<std::int64_t>::max();
  while (const can::Frame* frame = log.next()) {
    if (drive.frames.empty()) {
      first = frame->time_ns;
      if (to < 1e8) last = first + static_cast<std::int64_t>(1e9 * to);
    }
    if (frame->time_ns > last) break;
    drive.frames.push_back(*frame);
  }
  drive.buses = buses.all();
  // Poses before and after have no replay to compare with.
  if (!drive.frames.empty()) last = std::min(last, drive.frames.back().time_ns);
  std::ranges::sort(poses, {}, &estimator::CameraPose::capture_ns);
  const std::int64_t begin = first + static_cast<std::int64_t>(1e9 * from);
  std::erase_if(poses, [&](const estimator::CameraPose& pose) {
    return pose.capture_ns < begin || pose.capture_ns > last;
  });
  drive.reference = smoothed(poses, 0.25 * slowness(config));
  if (drive.reference->points.size() < 100)
    throw std::invalid_argument(name + ": too few poses to evaluate a replay of the drive");
  return drive;
}

Judge::Judge(std::span<const tools::Drive> drives) : drives_(drives), before_(scores({})) {}

Ratio Judge::ratio(const Patch& patch) {
  std::vector<Score> tried;
  try {
    tried = scores(patch);
  } catch (const std::invalid_argument&) {
    return {};
  }
  Ratio result;
  result.all = relative_error(tried, before_, goals);
  for (const std::size_t half : {0U, 1U}) {
    std::vector<Score> now, then;
    for (std::size_t i = half; i < tried.size(); i += 2) {
      now.push_back(tried[i]);
      then.push_back(before_[i]);
    }
    result.half[half] = relative_error(now, then, goals);
  }
  return result;
}

std::vector<Score> Judge::scores(const Patch& patch) {
  std::vector<Score> result;
  for (const tools::Drive& drive : drives_) {
    const daemon::Config& own = drive.config;
    daemon::Config config = daemon::parse_config(patched(own.text, own.file, patch), own.file);
    config.can.sources = own.can.sources;
    config.can.dbc = own.can.dbc;
    diagnostics::Diagnostics reported_already;
    static_cast<void>(daemon::load_databases(config, reported_already));
    const ReplayedDrive replayed = replay_drive(drive, config);
    ++replays_;
    const auto [x, y, yaw] = config.camera.lever_arm;
    for (const Trajectory& part : parts_of(*drive.reference, {x, y, yaw}, slowness(own)))
      result.push_back(score_of(evaluate(part, replayed.poses, Align::first)));
  }
  return result;
}

}  // namespace odomd::tools::fitting
