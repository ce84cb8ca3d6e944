// The uncertainty of a result, and the share that each input contributes (GUM, 5.1).
#pragma once

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <span>
#include <string>
#include <vector>

#include "tools/identify/common/measured.hpp"

namespace odomd::tools {

struct Input {
  std::string name;              ///< in words: "distance of the cords"
  Measured* measured = nullptr;  ///< the variable from which the result is computed
};

struct Contribution {
  std::string name;
  double sigma = 0.0;  ///< uncertainty of the result from this input alone
};

struct Propagated {
  Measured result;
  std::vector<Contribution> contributions;  ///< in the order of the inputs
};

/// `result` computes with the variables that the inputs point to; these are changed one by one and
/// restored. Inputs are independent: correlated quantities must be computed inside `result`.
[[nodiscard]] inline Propagated propagate(std::span<const Input> inputs,
                                          const std::function<double()>& result) {
  Propagated propagated;
  propagated.result.value = result();
  double variance = 0.0;
  for (const auto& [name, input] : inputs) {
    const double value = input->value;
    input->value = value + input->sigma;
    const double above = result();
    input->value = value - input->sigma;
    const double part = 0.5 * std::fabs(above - result());
    input->value = value;
    propagated.contributions.push_back({name, part});
    variance += part * part;
  }
  propagated.result.sigma = std::sqrt(variance);
  return propagated;
}

/// "mostly from the distance of the cords (71 %) and the swing's period (20 %)": shares of the
/// variance.
[[nodiscard]] inline std::string largest_contributions(const Propagated& propagated) {
  const double variance = propagated.result.sigma * propagated.result.sigma;
  if (!(variance > 0.0)) return "";
  std::vector<Contribution> parts = propagated.contributions;
  std::ranges::stable_sort(parts, std::greater<>{}, &Contribution::sigma);
  std::string text = "mostly from the ";
  for (std::size_t i = 0; i < parts.size() && i < 2; ++i) {
    const double share = parts[i].sigma * parts[i].sigma / variance;
    if (i > 0 && share < 0.1) break;
    text += (i > 0 ? " and the " : "") + fmt::format("{} ({:.0f} %)", parts[i].name, 100.0 * share);
  }
  return text;
}

}  // namespace odomd::tools
