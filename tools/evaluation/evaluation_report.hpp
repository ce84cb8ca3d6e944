// Evaluations side by side, for people and for programs.
#pragma once

#include <cstddef>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <vector>

#include "tools/evaluation/evaluation.hpp"

namespace odomd::tools {

struct EvaluationReport {
  std::string reference;
  Align align = Align::first;
  Frame frame = Frame::map;                   ///< of the estimates
  std::optional<estimator::Pose2> lever_arm;  ///< that the reference was moved by
  std::size_t fitted_windows = 0;             ///< where the lever arm was fitted
  std::vector<Evaluation> evaluations;        ///< at least one
  std::size_t baseline = 0;                   ///< the one that the others are compared with
};

[[nodiscard]] std::string align_name(Align align);      ///< "first"
[[nodiscard]] std::string align_in_words(Align align);  ///< "first (position and ...)"

/// A short name for each file: its stem, or the whole path where stems are alike.
[[nodiscard]] std::vector<std::string> short_names(const std::vector<std::string>& files);

/// By how much `value` is better than `baseline`, in percent. Nothing where the baseline is 0, or
/// less than a tenth of what it is usually on the drive: an error that happens to pass through zero
/// at the end makes a ratio of anything.
[[nodiscard]] std::optional<double> improvement(double value, double baseline, double usual = 0.0);

/// "12.3"; of what is more than twice as bad how many times: "94 x worse".
[[nodiscard]] std::string improvement_text(double percent);

/// What there is to say: a label and a cell an estimate.
[[nodiscard]] std::vector<std::vector<std::string>> report_rows(const EvaluationReport& report);

/// A table, a column a pose file, and what it is of.
[[nodiscard]] std::string as_text(const EvaluationReport& report);

/// SI units, radians.
[[nodiscard]] nlohmann::ordered_json json_of(const EvaluationReport& report);

/// With its newline; whatever is not UTF-8 replaced.
[[nodiscard]] std::string text_of(const nlohmann::ordered_json& json);

}  // namespace odomd::tools
