// The verdict on a drive, and the report: one self-contained HTML file for a browser, a phone and
// the printer. It is well-formed XML too, and neither runs scripts nor fetches anything.
#pragma once

#include <algorithm>
#include <cstdint>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include <nlohmann/json_fwd.hpp>

#include "tools/evaluation/evaluated_drive.hpp"

namespace odomd::tools::report {

// The verdict on a drive, on the terminal and at the top of a report: "good", "look at" or "wrong",
// with the reasons in sentences.

enum class Grade : std::uint8_t { good, look_at, wrong };

/// "good", "look at", "wrong".
[[nodiscard]] std::string in_words(Grade grade);

struct Reason {
  Grade grade = Grade::good;
  std::string sentence;
};

/// The verdict on one drive, from the estimate focus_of().
struct DriveVerdict {
  Grade grade = Grade::good;    ///< the worst of the reasons
  std::string subject;          ///< "full with the camera"
  std::string basis;            ///< what the estimate is compared with, and the limits of that
  std::vector<Reason> reasons;  ///< the worst first

  void add(Grade of_reason, std::string sentence) {
    grade = std::max(grade, of_reason);
    reasons.push_back({of_reason, std::move(sentence)});
  }
};

[[nodiscard]] DriveVerdict verdict_of(const EvaluatedDrive& drive);

/// One line for the grade, and one for each reason.
[[nodiscard]] std::string as_text(const DriveVerdict& verdict);
[[nodiscard]] nlohmann::ordered_json as_json(const DriveVerdict& verdict);

struct PageInfo {
  std::string title;  ///< empty: the drives' names
  std::string version;
  std::string command;  ///< the command that made the report
};

[[nodiscard]] std::string page(std::span<const EvaluatedDrive> drives, const PageInfo& info);

}  // namespace odomd::tools::report
