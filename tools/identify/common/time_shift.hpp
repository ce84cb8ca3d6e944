// The estimator of the time offset between two signals, one of which is a sum of known functions of
// the other.
//
//   y(t_i) = Σ_j c_j φ_j(t_i - D) + e_i
//
// is solved for the coefficients c and the offset D: first on a grid of offsets (a
// cross-correlation with coefficients), then in continuous time (tools/math/least_squares.hpp),
// with a covariance from blocks of time.
//
// Noise in φ_1 makes its derivative look larger than it is, and D more certain. D is determined
// only by the energy of that derivative after subtracting its noise and the part that the other
// functions explain.
#pragma once

#include <cstddef>
#include <limits>
#include <string>
#include <vector>

#include "tools/identify/common/signal_log.hpp"

namespace odomd::tools {

struct BasisFunction {
  Resampled function;
  double expected = 0.0;                                   ///< expected coefficient
  double sigma = std::numeric_limits<double>::infinity();  ///< standard deviation of `expected`
};

struct OffsetRegression {
  std::vector<double> t;  ///< [s], rising
  std::vector<double> y;
  std::vector<BasisFunction> basis;  ///< the first one determines the offset
  double range = 1.5;                ///< range of offsets: ± this [s]
  double block = 2.0;                ///< residuals further apart are independent [s]
  double slope_noise = 0.0;          ///< variance of the noise in the first function's derivative
};

struct Offset {
  double value = 0.0;  ///< D [s]: positive if y is late
  double sigma = std::numeric_limits<double>::infinity();
  std::vector<double> coefficients;
  double explained = 0.0;  ///< share of the variance of y, 0 to 1
  std::string failure;     ///< why the value is not valid; empty if it is
};

/// Needs at least 20 samples; otherwise `failure` says so.
[[nodiscard]] Offset solve(const OffsetRegression& regression);

/// The number of the block of this length [s] for each time, for covariance_by_blocks().
[[nodiscard]] std::vector<std::size_t> blocks_of(const std::vector<double>& t, double length);

}  // namespace odomd::tools
