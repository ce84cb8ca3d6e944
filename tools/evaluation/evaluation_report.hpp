// Evaluations side by side, as text and JSON.
#pragma once

#include <cstddef>
#include <nlohmann/json_fwd.hpp>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "tools/cli/text.hpp"
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

/// A figure of an evaluation: how it is computed, shown and explained.
struct Metric {
  using Value = std::optional<double>;  ///< in the unit of the label; nothing if it is not known

  std::string_view label;
  int decimals = 0;
  std::string_view definition;
  Value (*value)(const Evaluation& e, const Evaluation& baseline) = nullptr;
};

/// In the order of the report.
[[nodiscard]] std::span<const Metric> metrics();
[[nodiscard]] const Metric& metric(std::string_view label);

/// "12.3"; "-" if it is not known; "< -999" for an improvement below that.
[[nodiscard]] std::string text_of(Metric::Value value, std::string_view label, int decimals);

/// A column for each estimate, and a row for each metric that one of them has.
[[nodiscard]] Table metrics_table(const EvaluationReport& report);

/// The table, below a description.
[[nodiscard]] std::string as_text(const EvaluationReport& report);

/// In SI units and radians.
[[nodiscard]] nlohmann::ordered_json json_of(const EvaluationReport& report);

}  // namespace odomd::tools
