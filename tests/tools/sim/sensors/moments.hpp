// Moments of samples, and parameters without errors, for the tests of the sensors.
#pragma once

#include "tests/gtest.hpp"
#include "tools/sim/car/parameters.hpp"

namespace odomd::sim {

/// Parameters without errors; `changes` replace some of them.
inline ParameterSet ideal_parameters(const std::vector<Assignment>& changes = {},
                                     CarKind kind = CarKind::scale_car) {
  ParameterSet ideal = default_parameters(kind);
  make_ideal(ideal);
  for (const Assignment& change : changes) ideal[change.parameter] = change.value;
  return ideal;
}

struct Moments {
  double sum = 0.0, squares = 0.0;
  int count = 0;
  void add(double x) {
    sum += x;
    squares += x * x;
    ++count;
  }
  [[nodiscard]] double mean() const { return sum / count; }
  [[nodiscard]] double deviation() const { return std::sqrt(squares / count - mean() * mean()); }
};

}  // namespace odomd::sim
