// The verdict on a drive, on the terminal and at the top of a report: good, to look at, or wrong,
// with the reasons in sentences.
#pragma once

#include <algorithm>
#include <cstdint>
#include <nlohmann/json_fwd.hpp>
#include <string>
#include <utility>
#include <vector>

#include "tools/evaluation/evaluated_drive.hpp"

namespace odomd::tools::report {

enum class Grade : std::uint8_t { good, look_at, wrong };

/// "good", "look at", "wrong".
[[nodiscard]] std::string in_words(Grade grade);

struct Reason {
  Grade grade = Grade::good;
  std::string sentence;
};

/// The verdict on one drive, from the estimate focus_of().
struct Judgement {
  Grade grade = Grade::good;    ///< the worst of the reasons
  std::string subject;          ///< "full with the camera"
  std::string basis;            ///< what the estimate is compared with, and the limits of that
  std::vector<Reason> reasons;  ///< the worst first

  void add(Grade of_reason, std::string sentence) {
    grade = std::max(grade, of_reason);
    reasons.push_back({of_reason, std::move(sentence)});
  }
};

[[nodiscard]] Judgement verdict_of(const EvaluatedDrive& drive);

/// One line for the grade, and one for each reason.
[[nodiscard]] std::string as_text(const Judgement& verdict);
[[nodiscard]] nlohmann::ordered_json as_json(const Judgement& verdict);

}  // namespace odomd::tools::report
