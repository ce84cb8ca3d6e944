// The value of fitted numbers for the filter: replays the drive by dead reckoning with and without
// them, and compares it with its own poses.
#pragma once

#include <array>
#include <cstddef>
#include <functional>
#include <limits>
#include <span>
#include <string>
#include <vector>

#include "tools/cli/progress.hpp"
#include "tools/config_patch/config_patch.hpp"
#include "tools/drive_files/trajectory.hpp"
#include "tools/identify/common/finding.hpp"
#include "tools/replay/drive.hpp"

namespace odomd::tools::fitting {

/// The path of a car from noisy poses, smooth enough to compare with a filter's speed: a cubic
/// fitted to the poses `half` seconds around each time, every 20 ms; outliers lose their weight.
/// There is no point if poses are too few. Poses in the order of capture.
[[nodiscard]] Trajectory smoothed(std::span<const estimator::CameraPose> poses, double half);

/// A drive to replay, between two times after its first frame [s]; the reference is its smoothed
/// poses. Throws std::invalid_argument if there are too few of them.
[[nodiscard]] tools::Drive trial_drive(const std::string& name, const daemon::Config& config,
                                       std::span<const std::string> logs,
                                       std::vector<estimator::CameraPose> poses, double from,
                                       double to);

using Patch = std::vector<ConfigValue>;

/// Errors over those of the configuration, the geometric mean of those over 35 ms and over 1 s, and
/// the rms of position and heading: over all parts of the drives, over every second one, and over
/// the others.
struct Ratio {
  double all = std::numeric_limits<double>::infinity();
  std::array<double, 2> half{all, all};
};

/// Values that go into the configuration together or not at all.
struct Group {
  std::string name;
  Patch patch;
  std::vector<std::size_t> findings;  ///< that the values are of
  bool taken = false;
};

/// Takes the best group to take, or if there is none drops the best one to drop, until neither
/// helps. It takes nothing that increases the errors, drops nothing unless that clearly reduces
/// them, and does neither if it much increases those of a half. Returns the errors with what is
/// taken. `judge` replays with a patch.
[[nodiscard]] Ratio choose(std::vector<Group>& groups,
                           const std::function<Ratio(const Patch&)>& judge,
                           const ReportProgress& progress = {});

/// Marks the values that choose() does not take, with the reason: they stay as configured.
/// `progress` is called now and then. Drives are those of trial_drive().
void try_out(Findings& findings, std::span<const tools::Drive> drives,
             const ReportProgress& progress);

}  // namespace odomd::tools::fitting
