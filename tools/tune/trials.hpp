// Settings tried on drives, on all cores.
#pragma once

#include <cstddef>
#include <functional>
#include <optional>
#include <span>
#include <stdexcept>
#include <string>
#include <vector>

#include "estimator/common/settings.hpp"
#include "tools/config_patch/config_patch.hpp"
#include "tools/evaluation/drive_evaluation.hpp"
#include "tools/replay/drive.hpp"
#include "tools/tune/parameter.hpp"
#include "tools/tune/score.hpp"

namespace odomd::tools {

/// A value a parameter; nothing: as the configuration has it.
using Values = std::vector<std::optional<double>>;

struct TrialOutcome {
  std::vector<Score> scores;  ///< by drive; empty where it is impossible
  std::string impossible;     ///< why, as config_with() says it
};

/// The user has asked to stop.
class Stopped : public std::runtime_error {
 public:
  using std::runtime_error::runtime_error;
};

struct TrialSettings {
  std::span<const Drive> drives;
  std::span<const Parameter> parameters;
  std::optional<estimator::Model> model;  ///< nothing: the configuration's
  Measure measure;
  std::size_t threads = 1;
};

/// Called in the calling thread while trials run, with the replays done and in all; returns whether
/// to stop.
enum class GoOn : std::uint8_t { yes, no };
using Watch = std::function<GoOn(std::size_t done, std::size_t all)>;

/// The outcome of each trial, whatever the number of threads. Settings that the configuration
/// refuses are impossible; whatever else fails is thrown. `finished` is called for each trial as
/// soon as its last drive is done. Throws Stopped.
[[nodiscard]] std::vector<TrialOutcome> run_trials(
    const TrialSettings& settings, std::span<const Values> trials, const Watch& watch,
    const std::function<void(std::size_t trial, const TrialOutcome&)>& finished);

/// The drive's configuration with these numbers in it. Throws std::invalid_argument that names the
/// option, --set KEY=VALUE, whose value is refused, and why.
[[nodiscard]] daemon::Config config_with(const Drive& drive, std::span<const ConfigValue> numbers);

}  // namespace odomd::tools
