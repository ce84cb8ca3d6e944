// Replays drives by dead reckoning with other numbers in the configuration, and compares them with
// their own poses.
#pragma once

#include <array>
#include <cstddef>
#include <limits>
#include <span>
#include <string>
#include <vector>

#include "tools/config_patch/config_patch.hpp"
#include "tools/replay/drive.hpp"
#include "tools/tune/score.hpp"

namespace odomd::tools::fitting {

/// A drive to replay, between two times after its first frame [s]; the reference is its smoothed
/// poses. Throws std::invalid_argument if there are too few of them.
[[nodiscard]] tools::Drive trial_drive(const std::string& name, const daemon::Config& config,
                                       std::span<const std::string> logs,
                                       std::vector<estimator::CameraPose> poses, double from,
                                       double to);

using Patch = std::vector<ConfigValue>;

/// Errors over those of the configuration, the geometric mean of those over 35 ms and over 1 s, and
/// the rms of position and heading: over all parts of the drives, over the even-numbered ones, and
/// over the odd-numbered ones.
struct Ratio {
  double all = std::numeric_limits<double>::infinity();
  std::array<double, 2> half{all, all};
};

class Judge {
 public:
  /// The drives must outlive it. Replays them with the present configuration.
  explicit Judge(std::span<const tools::Drive> drives);

  /// Replays them with other numbers; infinity if the configuration is invalid or gives no pose.
  [[nodiscard]] Ratio ratio(const Patch& patch);

  [[nodiscard]] std::size_t replays() const { return replays_; }

 private:
  [[nodiscard]] std::vector<Score> scores(const Patch& patch);

  std::span<const tools::Drive> drives_;
  std::size_t replays_ = 0;
  std::vector<Score> before_;
};

}  // namespace odomd::tools::fitting
