// The fit as one problem of Ceres, and how uncertain its solution is.
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

/// Refers to all that it is given.
[[nodiscard]] Built build(const Setup& setup, const Settings& settings, Numbers<double>& p,
                          std::vector<Chain>& chains);

/// The covariance of the parameters into the result, at the solution. Throws std::runtime_error
/// where there is none.
void uncertainties(const Built& built, const Settings& settings, Result& result);

}  // namespace odomd::tools::fitting
