// The reference run of the paper author's own filter: 4,000 steps at 5 ms.
#pragma once

#include <algorithm>
#include <array>
#include <fstream>
#include <sstream>
#include <stdexcept>
#include <string>
#include <vector>

namespace odomd::estimator::testing {

struct GoldenRow {
  double steering, accel_x;        ///< u
  double yaw_rate, speed;          ///< z
  std::array<double, 6> expected;  ///< v_x, v_y, ψ̇, X, Y, ψ after predict and correct
};

/// Reads tests/data/paper_ekf_golden.csv.
inline std::vector<GoldenRow> read_golden() {
  std::ifstream file(ODOMD_TEST_DATA "/paper_ekf_golden.csv");
  std::vector<GoldenRow> rows;
  for (std::string line; std::getline(file, line);) {
    if (line.empty() || line.front() == '#') continue;
    std::replace(line.begin(), line.end(), ',', ' ');
    std::istringstream fields(line);
    GoldenRow& row = rows.emplace_back();
    fields >> row.steering >> row.accel_x >> row.yaw_rate >> row.speed;
    for (double& value : row.expected) fields >> value;
    if (!fields) throw std::runtime_error("not a row of ten numbers: " + line);
  }
  return rows;
}

}  // namespace odomd::estimator::testing
