// Moments of samples, and parameters without errors, for the tests of the sensors.
#pragma once

#include "tests/gtest.hpp"
#include "tools/sim/car/parameters.hpp"

namespace odomd::sim {

inline ParameterSet ideal_parameters() {
  ParameterSet parameters = default_parameters(CarKind::scale_car);
  make_ideal(parameters);
  return parameters;
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
