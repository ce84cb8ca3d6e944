// The report: one HTML file with everything in it, for a browser, a phone and the printer. It is
// well-formed XML too, and runs nothing and fetches nothing.
#pragma once

#include <span>
#include <string>

#include "tools/evaluation/evaluated_drive.hpp"

namespace odomd::tools::report {

struct PageInfo {
  std::string title;  ///< empty: the drives' names
  std::string version;
  std::string command;  ///< that made it
};

[[nodiscard]] std::string page(std::span<const EvaluatedDrive> drives, const PageInfo& info);

}  // namespace odomd::tools::report
