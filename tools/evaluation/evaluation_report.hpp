// Evaluations side by side, as text and JSON.
#pragma once

#include <cstddef>
#include <nlohmann/json_fwd.hpp>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "tools/evaluation/evaluation.hpp"

namespace odomd::tools {

struct EvaluationReport {
  std::string reference;
  Align align = Align::first;
  Frame frame = Frame::map;                   ///< of the estimates
  std::optional<estimator::Pose2> lever_arm;  ///< removed from the reference
  std::size_t fitted_windows = 0;       ///< number of windows if the lever arm was fitted, else 0
  std::vector<Evaluation> evaluations;  ///< at least one
  std::size_t baseline = 0;  ///< index of the evaluation that the others are compared with
};

[[nodiscard]] std::string align_in_words(Align align);  ///< "first (position and ...)"

/// A short name for each file: its stem, or the whole path if stems are equal.
[[nodiscard]] std::vector<std::string> short_names(const std::vector<std::string>& files);

/// By how much `value` is better than `baseline`, in percent; negative if it is worse. Nothing if
/// the baseline is 0, or less than a tenth of its usual value on the drive: an error that happens
/// to be near zero at the end makes the ratio meaningless.
[[nodiscard]] std::optional<double> improvement(double value, double baseline, double usual = 0.0);

/// One line: what the estimates are compared with, and the limits of their figures.
[[nodiscard]] std::string basis_in_words(Against against);
[[nodiscard]] std::string basis_in_words(const EvaluationReport& report);

/// A figure of an evaluation in the unit of its label; without a value if it is not known.
struct Metric {
  std::string_view label;
  int decimals = 0;
  std::optional<double> value;
};

/// "12.3"; "-" if it is not known; "< -999" for an improvement below that.
[[nodiscard]] std::string text_of(const Metric& metric);

/// The figures in the order of the report, with the same labels for all evaluations.
[[nodiscard]] std::vector<Metric> metrics_of(const Evaluation& e, const Evaluation& baseline);

/// The rows of the report: a label and one cell per estimate.
[[nodiscard]] std::vector<std::vector<std::string>> report_rows(const EvaluationReport& report);

/// A table with one column per estimate, below a description.
[[nodiscard]] std::string as_text(const EvaluationReport& report);

/// In SI units and radians.
[[nodiscard]] nlohmann::ordered_json json_of(const EvaluationReport& report);

/// The JSON and a newline; bytes that are not UTF-8 are replaced.
[[nodiscard]] std::string text_of(const nlohmann::ordered_json& json);

}  // namespace odomd::tools
