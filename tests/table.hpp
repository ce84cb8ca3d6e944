// A table in a raw string: "left -> right" in each line. A line that is indented by two spaces
// continues the previous one; ¶ in the left part means a line break; a line beginning with "# " is
// a comment.
#pragma once

#include <regex>
#include <sstream>

#include "tests/gtest.hpp"

namespace odomd {

/// Calls `check(left, right)` for every row.
template <typename Check>
void for_each_row(const char* table, Check&& check) {
  int rows = 0;
  std::istringstream lines(std::regex_replace(table, std::regex("\n  +"), " "));
  for (std::string line; std::getline(lines, line);) {
    if (line.empty() || line.starts_with("# ")) continue;
    const auto arrow = line.find(" -> ");
    ASSERT_NE(arrow, std::string::npos) << line;
    ++rows;
    check(std::regex_replace(line.substr(0, arrow), std::regex("¶"), "\n"), line.substr(arrow + 4));
  }
  EXPECT_GT(rows, 0) << "a table without a row";
}

}  // namespace odomd
