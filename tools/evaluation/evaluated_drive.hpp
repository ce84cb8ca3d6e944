// Estimates of one drive, side by side, with all that a report says of them.
#pragma once

#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "estimator/common/measurement.hpp"
#include "estimator/common/settings.hpp"
#include "tools/drive_files/beat_histogram.hpp"
#include "tools/drive_files/trajectory.hpp"
#include "tools/evaluation/drive_evaluation.hpp"
#include "tools/evaluation/evaluation_report.hpp"

namespace odomd::tools {

struct EvaluationWarning {
  std::string estimate;  ///< its name; empty: of the drive
  std::string text;
};

struct EvaluatedDrive {
  std::string name;
  EvaluationReport report;              ///< an evaluation an estimate
  std::optional<Trajectory> reference;  ///< of the centre of gravity; none of a closed loop
  std::vector<Trajectory> estimates;
  std::vector<ReplayedDrive> replays;  ///< of each estimate, its poses moved to `estimates`; of
                                       ///< pose files none
  std::vector<estimator::CameraPose> cameras;
  bool is_part = false;  ///< judged by --from or --to; what the filter says of samples is not
  bool begins_elsewhere = false;  ///< the configuration's initial pose is of another drive
  std::optional<BeatHistogram> beat;
  std::optional<daemon::Config> config;  ///< of replays
  std::vector<EvaluationWarning> warnings;
};

/// "ESTIMATE: what there is to say", one a warning.
[[nodiscard]] std::vector<std::string> worded(const std::vector<EvaluationWarning>& warnings);

/// Short names of the estimates, and their colours: a model has its own in every picture.
[[nodiscard]] std::vector<std::string> names_of(const EvaluatedDrive& drive);
[[nodiscard]] std::vector<std::string> colours_of(const EvaluatedDrive& drive);

/// How to judge, be it pose files or folders.
struct Judging {
  Against against = Against::reference;
  std::optional<Align> align;  ///< else the usual one; of pose files `first`
  Frame frame = Frame::map;
  std::string from;  ///< a time of the files [s], "+T": after the first row of the reference, or of
  std::string to;    ///< the estimate where there is none; empty: all
  std::optional<estimator::Pose2> lever_arm;
  bool fit_lever_arm = false;
  std::string baseline;  ///< by its short name; empty: kinematic, else the first
  Judgements judgements = Judgements::forget;
  std::filesystem::path beat;  ///< a beat.csv; empty: the folder's, where there is one
};

/// Pose files against a reference (empty: of a closed loop). Throws std::invalid_argument.
[[nodiscard]] EvaluatedDrive evaluate_files(const std::string& reference,
                                            const std::vector<std::string>& poses,
                                            const Judging& judging);

/// What a drive is compared by unless models are named: inertial only where there is a gyro.
[[nodiscard]] std::vector<estimator::Model> usual_models(const daemon::Config& config);

/// A drive's folder through each of the models, through usual_models() where none is named. Throws
/// std::invalid_argument.
[[nodiscard]] EvaluatedDrive evaluate_folder(const DriveFiles& files,
                                             const std::vector<estimator::Model>& models,
                                             const Judging& judging);

}  // namespace odomd::tools
