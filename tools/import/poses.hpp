// camera.csv and truth.csv from the mapped columns.
#pragma once

#include <cstddef>
#include <cstdint>
#include <string>
#include <vector>

#include "tools/import/read_tables.hpp"

namespace odomd::tools {

/// The text of a file, its times `shift_ns` later than the rows'. Rows with a missing value are
/// left out.
struct PoseText {
  std::string text;  ///< empty: no column is mapped to it
  std::size_t rows = 0, left_out = 0;
};

/// Both throw std::invalid_argument that says which column lacks.
[[nodiscard]] PoseText camera_of(const ColumnMap& map, const std::vector<TableRows>& tables,
                                 std::int64_t shift_ns);
[[nodiscard]] PoseText truth_of(const ColumnMap& map, const std::vector<TableRows>& tables,
                                std::int64_t shift_ns);

}  // namespace odomd::tools
