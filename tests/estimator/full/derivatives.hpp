// What a prediction says of its dependence on the state, against central differences.
#pragma once

#include "estimator/ekf/prediction.hpp"
#include "estimator/ekf/state.hpp"

namespace odomd::estimator::full::testing {

/// ∂h/∂x as the prediction states it.
inline Vector stated(const Prediction& prediction) {
  Vector by = Vector::Zero();
  for (std::size_t i = 0; i < prediction.count(); ++i) {
    by[prediction.state(i)] += prediction.by(i);
  }
  return by;
}

/// The same by differences. `predict`: a State to its Prediction.
template <typename Predict>
Vector differences(const State& at, const Predict& predict, double step = 1e-6) {
  Vector by;
  for (Eigen::Index i = 0; i < at::size; ++i) {
    State above = at;
    State below = at;
    above.mean[i] += step;
    below.mean[i] -= step;
    by[i] = (predict(above).value - predict(below).value) / (2.0 * step);
  }
  return by;
}

}  // namespace odomd::estimator::full::testing
