// The verdict on a drive, on the terminal and at the top of a report: good, to look at, or wrong,
// and why, in sentences.
#pragma once

#include <cstdint>
#include <nlohmann/json_fwd.hpp>
#include <string>
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

/// Of one drive, judged by the estimate that the report is about: focus_of().
struct Verdict {
  Grade grade = Grade::good;    ///< the worst of the reasons
  std::string subject;          ///< "full with the camera"
  std::string basis;            ///< what it was compared with, and what that is worth
  std::vector<Reason> reasons;  ///< the worst first
};

[[nodiscard]] Verdict verdict_of(const EvaluatedDrive& drive);

/// A line of its own for the grade and for each reason.
[[nodiscard]] std::string as_text(const Verdict& verdict);
[[nodiscard]] nlohmann::ordered_json as_json(const Verdict& verdict);

}  // namespace odomd::tools::report
