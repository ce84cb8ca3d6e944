#include "tools/evaluation/drive_checks.hpp"

#include "daemon/diagnostics/diagnostic.hpp"
#include "tools/diagnostics/drive_mismatch.hpp"
#include "tools/diagnostics/heading_check.hpp"
#include "tools/diagnostics/initial_pose_check.hpp"
#include "tools/evaluation/evaluation_checks.hpp"
#include "tools/evaluation/time_check.hpp"

namespace odomd::tools {

diagnostics::Diagnostics check_drive(const Drive& drive) {
  const daemon::Config& config = drive.config;
  const ReplayedDrive replayed = replay_drive(drive, config);
  diagnostics::Diagnostics warnings = replayed.warnings;
  if (replayed.summary.camera_units.empty())
    append(warnings, check_initial_pose(config, drive.cameras, replayed.summary.first_tick_ns));
  if (!drive.reference) return warnings;
  const Trajectory reference = reference_of(drive);
  if (const auto units = check_units_of(reference, replayed.poses, "the estimate");
      !units.empty()) {
    append(warnings, units);
    return warnings;
  }
  append(warnings, check_headings(reference));
  // A model that has stopped no longer turns, and has been reported already.
  std::optional<diagnostics::Diagnostic> mismatch;
  if (!replayed.summary.fault_ns) mismatch = drive_mismatch(reference, replayed.poses);
  if (mismatch) mismatch->subject = daemon::name_of(config.model);
  append(warnings,
         mismatch ? mismatch
                  : check_times(reference, drive, usual_align(!drive.cameras.empty(), Frame::map)));
  return warnings;
}

}  // namespace odomd::tools
