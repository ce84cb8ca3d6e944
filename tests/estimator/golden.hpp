// The reference run of the paper author's own filter: 4,000 steps at 5 ms.
#pragma once

#include <array>
#include <cstddef>
#include <vector>

namespace odomd::estimator::testing {

struct GoldenRow {
  double steering, accel_x;        ///< u
  double yaw_rate, speed;          ///< z
  std::array<double, 6> expected;  ///< v_x, v_y, ψ̇, X, Y, ψ after predict and correct
};

/// Reads tests/data/paper_ekf_golden.csv; throws std::runtime_error on failure.
[[nodiscard]] std::vector<GoldenRow> read_golden();

}  // namespace odomd::estimator::testing
