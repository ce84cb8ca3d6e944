// The fit as a Ceres problem, and the uncertainty of its solution.
#pragma once

#include <ceres/problem.h>

#include <cstddef>
#include <memory>
#include <vector>

#include "tools/identify/fit/chain.hpp"
#include "tools/identify/fit/solver.hpp"

namespace odomd::tools::fitting {

struct Built {
  std::unique_ptr<ceres::Problem> problem;
  std::vector<ceres::ResidualBlockId> blocks;  // windows in order, then the prior
  std::vector<std::size_t> cluster;            // of each block
  std::vector<double*> unknowns;               // the parameters first
};

/// Keeps references to its arguments.
[[nodiscard]] Built build(const Setup& setup, const Settings& settings, Numbers<double>& p,
                          std::vector<Chain>& chains);

/// Writes the covariance of the parameters at the solution to the result. Throws std::runtime_error
/// if there is none.
void uncertainties(const Built& built, const Settings& settings, Result& result);

}  // namespace odomd::tools::fitting
