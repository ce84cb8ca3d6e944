// The report: one self-contained HTML file for a browser, a phone and the printer. It is
// well-formed XML too, and neither runs scripts nor fetches anything.
#pragma once

#include <span>
#include <string>

#include "tools/evaluation/evaluated_drive.hpp"

namespace odomd::tools::report {

struct PageInfo {
  std::string title;  ///< empty: the drives' names
  std::string version;
  std::string command;  ///< the command that made the report
};

[[nodiscard]] std::string page(std::span<const EvaluatedDrive> drives, const PageInfo& info);

}  // namespace odomd::tools::report
