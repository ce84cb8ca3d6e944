// The time offset between two signals, where one is a sum of known functions of the other.
//
//   y(t_i) = Σ_j c_j φ_j(t_i - D) + e_i
//
// is solved for the coefficients c and the offset D: first over a grid of offsets (a
// cross-correlation with coefficients), then in continuous time (tools/math/least_squares.hpp), its
// covariance by blocks of time.
//
// Noise in φ_1 makes its derivative look larger than the signal's, and D better known than it is:
// of the energy of that derivative, less what the other functions explain, only the part that is
// not noise determines D.
#pragma once

#include <cstddef>
#include <limits>
#include <string>
#include <vector>

#include "tools/identify/common/resampled.hpp"

namespace odomd::tools {

struct BasisFunction {
  Resampled function;
  double expected = 0.0;                                   ///< of its coefficient
  double sigma = std::numeric_limits<double>::infinity();  ///< standard deviation of that
};

struct OffsetRegression {
  std::vector<double> t;  ///< [s], rising
  std::vector<double> y;
  std::vector<BasisFunction> basis;  ///< of these, the first is the one that carries the offset
  double range = 1.5;                ///< offsets from minus to plus this are tried [s]
  double block = 2.0;                ///< residuals further apart are independent [s]
  double slope_noise = 0.0;          ///< variance of the noise in the first function's derivative
};

struct Offset {
  double value = 0.0;  ///< D [s]: positive where y is late
  double sigma = std::numeric_limits<double>::infinity();
  std::vector<double> coefficients;
  double explained = 0.0;  ///< share of the variance of y, 0 to 1
  std::string failure;     ///< why the value is not valid; empty: it is
};

/// Needs at least 20 samples, else says so in `failure`.
[[nodiscard]] Offset solve(const OffsetRegression& regression);

/// Numbers the blocks of this length [s] that times lie in, for covariance_by_blocks().
[[nodiscard]] std::vector<std::size_t> blocks_of(const std::vector<double>& t, double length);

}  // namespace odomd::tools
