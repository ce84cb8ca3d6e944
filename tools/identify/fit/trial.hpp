// The benefit of fitted numbers for the filter: replays the drive in dead reckoning with and
// without them, and compares the result with the drive's own poses.
#pragma once

#include <array>
#include <cstddef>
#include <functional>
#include <limits>
#include <span>
#include <string>
#include <vector>

#include "tools/cli/output.hpp"
#include "tools/config_patch/config_patch.hpp"
#include "tools/drive_files/trajectory.hpp"
#include "tools/identify/common/finding.hpp"
#include "tools/identify/fit/drive.hpp"
#include "tools/replay/drive.hpp"

namespace odomd::tools::fitting {

/// The path of a car from noisy poses, smooth enough to compare with a filter's speed: every 20 ms
/// a cubic fitted to the poses within `half` seconds; outliers lose their weight. Empty if there
/// are too few poses. Poses in the order of capture.
[[nodiscard]] Trajectory smoothed(std::span<const estimator::CameraPose> poses, double half);

/// A part of a drive, to replay in dead reckoning; the reference is its smoothed poses. Throws
/// std::invalid_argument if there are too few of them.
[[nodiscard]] tools::Drive trial_drive(tools::Drive drive, std::vector<estimator::CameraPose> poses,
                                       const Part& part = {});

using Patch = std::vector<ConfigValue>;

/// Errors relative to the configuration's: geometric mean of the ratios for 35 ms, 1 s, position
/// rms and heading rms. `all`: over all parts of the drives; `half`: over every second part, and
/// over the others.
struct Ratio {
  double all = std::numeric_limits<double>::infinity();
  std::array<double, 2> half{all, all};
};

/// Values that go into the configuration together or not at all.
struct Group {
  std::string name;
  Patch patch;
  std::vector<std::size_t> findings;  ///< the findings with these values
  bool accepted = false;
};

/// Repeatedly accepts the best group or, if none helps, drops the most harmful one, until neither
/// helps. Accepts nothing that increases the errors, drops a group only if that clearly reduces
/// them, and makes no change that much increases the errors on half of the parts. Returns the
/// errors with the accepted groups. `judge` replays with a patch.
[[nodiscard]] Ratio choose(std::vector<Group>& groups,
                           const std::function<Ratio(const Patch&)>& judge,
                           const ReportProgress& progress = {});

/// Marks values that choose() rejects, with the reason: they stay as configured. `progress` is
/// called occasionally. Drives come from trial_drive().
void try_out(Findings& findings, std::span<const tools::Drive> drives,
             const ReportProgress& progress);

}  // namespace odomd::tools::fitting
