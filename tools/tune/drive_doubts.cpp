#include "tools/tune/drive_doubts.hpp"

#include <stdexcept>
#include <utility>

#include "tools/diagnostics/drive_mismatch.hpp"
#include "tools/diagnostics/heading_doubt.hpp"
#include "tools/diagnostics/initial_pose_doubt.hpp"
#include "tools/evaluation/evaluation_doubts.hpp"
#include "tools/evaluation/time_doubt.hpp"

namespace odomd::tools {

std::vector<std::string> drive_doubts(const Drive& drive, std::optional<estimator::Model> model,
                                      const Measure& measure) try {
  if (!drive.reference) return {};
  daemon::Config config = drive.config;
  if (model) config.model = *model;
  const ReplayedDrive replayed = replay_drive(drive, config, measure.frame);
  std::vector<std::string> doubts = replayed.doubts;
  if (auto doubt = initial_pose_doubt(config, drive.cameras, replayed.summary.first_tick_ns);
      doubt && replayed.summary.camera_units.empty())
    doubts.push_back(*std::move(doubt));
  const Trajectory reference = measure.lever_arm
                                   ? at_centre_of_gravity(*drive.reference, *measure.lever_arm)
                                   : *drive.reference;
  const auto take = [&doubts](std::string doubt) {
    if (!doubt.empty()) doubts.push_back(std::move(doubt));
  };
  if (const std::string units = unit_doubt_beside(reference, replayed.poses, "the estimate");
      !units.empty()) {
    take(reference.name + ": " + units);
    return doubts;
  }
  take(heading_doubt(reference));
  // A model that has stopped turns no more, and is told already.
  const std::string mismatch =
      replayed.summary.fault_ns ? "" : drive_mismatch(reference, replayed.poses);
  if (!mismatch.empty())
    take(std::string(daemon::name_of(config.model)) + ": " + mismatch);
  else
    take(time_doubt(reference, drive,
                    measure.align.value_or(usual_align(!drive.cameras.empty(), measure.frame))));
  return doubts;
} catch (const std::invalid_argument&) {
  return {};
}

}  // namespace odomd::tools
