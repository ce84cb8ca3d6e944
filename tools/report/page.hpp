// The report: one self-contained HTML file for a browser, a phone and the printer. It is
// well-formed XML too, and neither runs scripts nor fetches anything.
#pragma once

#include <span>
#include <string>
#include <string_view>

#include "tools/evaluation/evaluated_drive.hpp"

namespace odomd::tools::report {

struct PageInfo {
  std::string title;  ///< empty: the drives' names
  std::string version;
  std::string command;  ///< the command that made the report
};

/// One sentence about the label of a row or a column; empty for names of estimates and the like.
[[nodiscard]] std::string definition_of(std::string_view label);

[[nodiscard]] std::string page(std::span<const EvaluatedDrive> drives, const PageInfo& info);

}  // namespace odomd::tools::report
