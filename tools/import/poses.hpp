// Camera poses and the truth from the mapped columns.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <vector>

#include "estimator/common/measurement.hpp"
#include "tools/import/read_tables.hpp"

namespace odomd::tools {

struct ImportedCamera {
  std::vector<estimator::CameraPose> poses;  ///< in the order of arrival
  std::size_t left_out = 0;                  ///< rows with a missing value
};

struct ImportedTruth {
  struct Row {
    std::int64_t time_ns = 0;
    double x = 0.0, y = 0.0, yaw = 0.0;
    std::array<double, 3> motion{};  ///< vx, vy, yaw_rate
  };
  std::vector<Row> rows;
  bool has_motion = false;
  std::size_t left_out = 0;
};

/// Both throw std::invalid_argument that says which column lacks.
[[nodiscard]] ImportedCamera camera_of(const ColumnMap& map, const Tables& tables);
[[nodiscard]] ImportedTruth truth_of(const ColumnMap& map, const Tables& tables);

}  // namespace odomd::tools
