// The fit as a Ceres problem, and the uncertainty of its solution.
#pragma once

#include <ceres/problem.h>

#include <memory>
#include <vector>

#include "tools/identify/fit/chain.hpp"
#include "tools/identify/fit/solver.hpp"

namespace odomd::tools::fitting {

struct Built {
  std::unique_ptr<ceres::Problem> problem;
  std::vector<double> p;          ///< the free parameters, the first of the problem's blocks
  std::vector<int> cluster_rows;  ///< residuals of the windows that count together, in order
};

/// The problem refers to the setup and the chains.
[[nodiscard]] Built build(const Setup& setup, const Settings& settings, const Numbers<double>& p,
                          std::vector<Chain>& chains);

/// Writes the covariance of the parameters at the solution to the result. Throws std::runtime_error
/// if there is none.
void uncertainties(const Built& built, const Settings& settings, Result& result);

}  // namespace odomd::tools::fitting
