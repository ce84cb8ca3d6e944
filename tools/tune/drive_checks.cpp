#include "tools/tune/drive_checks.hpp"

#include <stdexcept>
#include <utility>

#include "tools/diagnostics/drive_mismatch.hpp"
#include "tools/diagnostics/heading_check.hpp"
#include "tools/diagnostics/initial_pose_check.hpp"
#include "tools/evaluation/evaluation_checks.hpp"
#include "tools/evaluation/time_check.hpp"

namespace odomd::tools {

std::vector<std::string> drive_warnings(const Drive& drive, std::optional<estimator::Model> model,
                                        const Measure& measure) try {
  if (!drive.reference) return {};
  daemon::Config config = drive.config;
  if (model) config.model = *model;
  const ReplayedDrive replayed = replay_drive(drive, config, measure.frame);
  std::vector<std::string> warnings = replayed.warnings;
  if (auto warning = initial_pose_warning(config, drive.cameras, replayed.summary.first_tick_ns);
      warning && replayed.summary.camera_units.empty())
    warnings.push_back(*std::move(warning));
  const Trajectory reference = measure.lever_arm
                                   ? at_centre_of_gravity(*drive.reference, *measure.lever_arm)
                                   : *drive.reference;
  const auto take = [&warnings](std::string warning) {
    if (!warning.empty()) warnings.push_back(std::move(warning));
  };
  if (const std::string units = unit_warning_between(reference, replayed.poses, "the estimate");
      !units.empty()) {
    take(reference.name + ": " + units);
    return warnings;
  }
  take(heading_warning(reference));
  // A model that has stopped no longer turns, and has been reported already.
  const std::string mismatch =
      replayed.summary.fault_ns ? "" : drive_mismatch(reference, replayed.poses);
  if (!mismatch.empty())
    take(std::string(daemon::name_of(config.model)) + ": " + mismatch);
  else
    take(time_warning(reference, drive,
                      measure.align.value_or(usual_align(!drive.cameras.empty(), measure.frame))));
  return warnings;
} catch (const std::invalid_argument&) {
  return {};
}

}  // namespace odomd::tools
