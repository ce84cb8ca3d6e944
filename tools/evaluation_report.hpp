// Evaluations side by side, for people and for programs.
#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "tools/evaluation.hpp"

namespace odomd::tools {

struct EvaluationReport {
  std::string reference;
  Align align = Align::first;
  Frame frame = Frame::map;                   ///< of the estimates
  std::optional<estimator::Pose2> lever_arm;  ///< that the reference was moved by
  std::size_t fitted_windows = 0;             ///< where the lever arm was fitted
  std::vector<Evaluation> evaluations;        ///< at least one; the first is compared against
};

[[nodiscard]] std::string align_name(Align align);

/// A short name for each file: its stem, or the whole path where stems are alike.
[[nodiscard]] std::vector<std::string> short_names(const std::vector<std::string>& files);

/// By how much `value` is better than `baseline`, in percent; nothing where the baseline is 0.
[[nodiscard]] std::optional<double> improvement(double value, double baseline);

/// A table, a column a pose file.
[[nodiscard]] std::string as_text(const EvaluationReport& report);

/// One JSON object with its newline: SI units, radians.
[[nodiscard]] std::string as_json(const EvaluationReport& report);

}  // namespace odomd::tools
