// The uncertainty of a result from those of its inputs, and which input it comes from (GUM, 5.1).
#pragma once

#include <functional>
#include <span>
#include <string>
#include <vector>

#include "tools/identify/common/finding.hpp"

namespace odomd::tools {

struct Input {
  std::string name;  ///< in words: "distance of the cords"
  Measured measured;
};

struct Contribution {
  std::string name;
  double sigma = 0.0;  ///< of the result, from this input alone
};

struct Propagated {
  Measured result;
  std::vector<Contribution> contributions;  ///< in the order of the inputs
};

/// The inputs are independent; correlated quantities must be computed inside `result_of`.
[[nodiscard]] Propagated propagate(
    std::span<const Input> inputs,
    const std::function<double(const std::vector<double>&)>& result_of);

/// "mostly from the distance of the cords (71 %) and the swing's period (20 %)", parts of the
/// variance.
[[nodiscard]] std::string largest_contributions(const Propagated& propagated);

}  // namespace odomd::tools
