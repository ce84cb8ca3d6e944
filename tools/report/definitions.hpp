// What each figure of a report means, shown where it is printed.
#pragma once

#include <string>
#include <string_view>

namespace odomd::tools::report {

/// One sentence for the label of a row or a column; empty for names of estimates and the like.
[[nodiscard]] std::string definition_of(std::string_view label);

}  // namespace odomd::tools::report
