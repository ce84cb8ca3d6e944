// Estimates of one drive with all data for a report; tables and JSON of several drives.
#pragma once

#include <cstdint>
#include <filesystem>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include <nlohmann/json_fwd.hpp>

#include "daemon/diagnostics/diagnostic.hpp"
#include "estimator/common/measurement.hpp"
#include "estimator/common/settings.hpp"
#include "tools/cli/text.hpp"
#include "tools/drive_files/drive_tables.hpp"
#include "tools/drive_files/trajectory.hpp"
#include "tools/evaluation/drive_evaluation.hpp"
#include "tools/evaluation/evaluation_report.hpp"

namespace odomd::tools {

struct EvaluatedDrive {
  std::string name;
  EvaluationReport report;              ///< one evaluation per estimate
  std::optional<Trajectory> reference;  ///< of the centre of gravity: truth or camera, or none
  std::vector<Trajectory> estimates;
  std::vector<ReplayedDrive> replays;  ///< one per estimate, without its poses, which are in
                                       ///< `estimates`; empty for pose files
  std::vector<estimator::CameraPose> cameras;  ///< including those that the replay left out
  bool is_part = false;  ///< limited by --from or --to; sample statistics cover the whole drive
  bool loop_is_assumed = false;   ///< without --closed-loop: the end is near the start
  bool begins_elsewhere = false;  ///< the configuration's initial pose belongs to another drive
  std::optional<odom_beat> beat;
  std::optional<daemon::Config> config;  ///< of replays
  diagnostics::Diagnostics warnings;
};

/// Whether the estimates were replayed with the camera's poses.
[[nodiscard]] bool camera_came_in(const EvaluatedDrive& drive);

/// Short names of the estimates, and their colours: a model has the same colour in every picture.
[[nodiscard]] std::vector<std::string> names_of(const EvaluatedDrive& drive);
[[nodiscard]] std::vector<std::string> colours_of(const EvaluatedDrive& drive);

/// How to evaluate, for pose files and folders.
struct Judging {
  Against against = Against::reference;  ///< reference or closed_loop; a drive without truth.csv
                                         ///< uses its camera, or its start if it is a closed loop,
                                         ///< or else nothing
  std::optional<Align> align;            ///< unset: usual_align() (`first` for pose files)
  Frame frame = Frame::map;
  std::string from;  ///< a time in the files [s]; "+T": after the first row of the reference, or
                     ///< else of the estimate
  std::string to;    ///< a time in the same form; empty: to the end
  std::optional<estimator::Pose2> lever_arm;
  bool fit_lever_arm = false;
  std::string baseline;  ///< short name; empty: kinematic or else the first estimate; without a
                         ///< steering signal, inertial or else the last estimate
  Judgements judgements = Judgements::forget;
  std::filesystem::path beat;  ///< a beat.csv; empty: the folder's, if there is one
};

/// Evaluates pose files against a reference (empty: as a closed loop). Throws
/// std::invalid_argument.
[[nodiscard]] EvaluatedDrive evaluate_files(const std::string& reference,
                                            const std::vector<std::string>& poses,
                                            const Judging& judging);

/// The default models: inertial only if there is a gyro.
[[nodiscard]] std::vector<estimator::Model> usual_models(const daemon::Config& config);

/// Evaluates a drive's folder with each of the models; if empty, usual_models(). Throws
/// std::invalid_argument.
[[nodiscard]] EvaluatedDrive evaluate_folder(const DriveFiles& files,
                                             const std::vector<estimator::Model>& models,
                                             const Judging& judging);

// The main figures of several estimates on several drives: the paper's table.

/// One row per drive and estimate. If several drives have the same estimates, one row per estimate
/// with the means follows. Leaves out empty columns, and drive names if there is one drive.
[[nodiscard]] Table summary_table(std::span<const EvaluatedDrive> drives);

/// The definition of the metric with this label or this header; empty for other words.
[[nodiscard]] std::string_view definition_of(std::string_view label);

/// Verdicts on the samples and their innovations: one row per source of the drive.
[[nodiscard]] Table source_table(const ReplaySummary& summary);

/// Everything as JSON.
[[nodiscard]] nlohmann::ordered_json summary_json(std::span<const EvaluatedDrive> drives);

}  // namespace odomd::tools
