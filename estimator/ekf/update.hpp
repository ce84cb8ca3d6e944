// The predicted sample with its derivatives, and the update of mean and covariance.
//
// docs/model.md, "Update".
#pragma once

#include <array>
#include <cmath>
#include <cstddef>

#include "estimator/common/symmetric3.hpp"
#include "estimator/ekf/state.hpp"

namespace odomd::estimator::full {

/// Degrees of freedom of noise with heavy tails, Student's t.
inline constexpr double student_degrees = 4.0;

/// h(x, s) with its nonzero derivatives and R, the variance of the sample about h: sensor noise and
/// model error.
class Prediction {
 public:
  double value = 0.0;
  double variance = 0.0;
  double relative = 0.0;  ///< part of R that the noise scale of a wheel multiplies
  double slack = 0.0;     ///< part of R that does not enter the gain
  double slip = 0.0;      ///< part of R: variance of slip, from speed changes that no car can make
  SlowVector by_slow = SlowVector::Zero();  ///< ∂h/∂s

  /// Adds `by` to ∂h/∂(state).
  void depends_on(at::Index state, double by) noexcept {
    states_[count_] = state;
    by_[count_] = by;
    ++count_;
  }
  [[nodiscard]] std::size_t count() const noexcept { return count_; }
  [[nodiscard]] at::Index state(std::size_t i) const noexcept { return states_[i]; }
  [[nodiscard]] double by(std::size_t i) const noexcept { return by_[i]; }

 private:
  std::array<at::Index, 8> states_{};
  std::array<double, 8> by_{};
  std::size_t count_ = 0;
};

/// ν = z - h and its variance S = (H P Hᵀ + R) + G P_s Gᵀ with G = H B + ∂h/∂s: the first part from
/// state and sample noise, the second from the slow errors.
struct Innovation {
  double value = 0.0;
  double variance = 1.0;                                 ///< S
  double variance_of_noise = 1.0;                        ///< H P Hᵀ + R
  double slack = 0.0;                                    ///< part of R, see Prediction
  Vector covariance_with_state = Vector::Zero();         ///< P Hᵀ
  SlowVector by_slow = SlowVector::Zero();               ///< Gᵀ
  SlowVector covariance_with_slow = SlowVector::Zero();  ///< P_s Gᵀ

  /// NIS, νᵀ S⁻¹ ν: χ² with one degree of freedom if the filter is consistent.
  [[nodiscard]] double squared_ratio() const noexcept { return value * value / variance; }
};

[[nodiscard]] inline Innovation innovation(const State& state, const Prediction& prediction,
                                           double measured) noexcept {
  Vector by_state = Vector::Zero();
  SlowVector by_slow = prediction.by_slow;
  for (std::size_t i = 0; i < prediction.count(); ++i) {
    by_state += prediction.by(i) * state.covariance.col(prediction.state(i));
    by_slow += prediction.by(i) * state.slow.sensitivity.row(prediction.state(i)).transpose();
  }
  double variance_of_noise = prediction.variance;
  for (std::size_t i = 0; i < prediction.count(); ++i) {
    variance_of_noise += prediction.by(i) * by_state[prediction.state(i)];
  }
  const SlowVector with_slow = state.slow.covariance.lazyProduct(by_slow);
  return {.value = measured - prediction.value,
          .variance = variance_of_noise + by_slow.dot(with_slow),
          .variance_of_noise = variance_of_noise,
          .slack = prediction.slack,
          .covariance_with_state = by_state,
          .by_slow = by_slow,
          .covariance_with_slow = with_slow};
}

/// K = P Hᵀ / (H P Hᵀ + R - slack), which is optimal if the slow errors are known.
[[nodiscard]] inline Vector optimal_gain(const Innovation& nu) noexcept {
  return nu.covariance_with_state / (nu.variance_of_noise - nu.slack);
}

/// x ← x + K ν, P ← (I - K H) P (I - K H)ᵀ + K R Kᵀ, B ← B - K G: Joseph's form, valid for any
/// gain. With a = P Hᵀ and b = a - (H P Hᵀ + R) K / 2: P - K bᵀ - b Kᵀ, symmetric to the bit.
inline void correct(State& state, const Innovation& nu, const Vector& gain) noexcept {
  const Vector b = nu.covariance_with_state - (0.5 * nu.variance_of_noise) * gain;
  for (Eigen::Index i = 0; i < at::size; ++i) {
    if (gain[i] == 0.0) {
      state.covariance.col(i) -= b[i] * gain;
      continue;
    }
    state.covariance.col(i) -= b[i] * gain + gain[i] * b;
    state.slow.sensitivity.row(i) -= gain[i] * nu.by_slow.transpose();
  }
  state.mean += gain * nu.value;
}

/// Corrects the slow errors after correct(): L = P_s Gᵀ / S, rows outside `corrected` zero,
/// s ← s + L ν, x ← x + B L ν. This is Friedland's form of the joint filter, and equals it if
/// correct() took the optimal gain and no slow error walks.
inline void correct_slow_errors(State& state, const Innovation& nu,
                                const SlowVector& corrected) noexcept {
  if (corrected.isZero(0.0)) {
    return;
  }
  SlowErrors& s = state.slow;
  const SlowVector& c = nu.covariance_with_slow;
  const SlowVector b = c - 0.5 * c.cwiseProduct(corrected);  // c - ½ S L
  for (Eigen::Index i = 0; i < slow::size; ++i) {
    if (corrected[i] == 0.0) {
      continue;
    }
    const double gain = c[i] / nu.variance;
    s.covariance.col(i) -= gain * b;
    s.covariance.row(i) -= gain * b.transpose();
    s.mean[i] += gain * nu.value;
    state.mean += gain * nu.value * s.sensitivity.col(i);
  }
}

/// Selections of slow errors for correct_slow_errors().
[[nodiscard]] inline SlowVector none() noexcept {
  return SlowVector::Zero();
}
[[nodiscard]] inline SlowVector all() noexcept {
  return SlowVector::Ones();
}
[[nodiscard]] inline SlowVector only(slow::Index index) noexcept {
  return SlowVector::Unit(index);
}

/// Freezes the effect of a slow error on the pose: later corrections of it do not move the pose.
inline void detach_from_pose(State& state, slow::Index index) noexcept {
  auto by = state.slow.sensitivity.col(index).head<3>();
  const Eigen::Vector3d made = std::sqrt(state.variance(index)) * by;
  state.covariance.topLeftCorner<3, 3>() += made * made.transpose();
  by.setZero();
}

/// Sets the standard deviation of a state, without correlations.
inline void forget(State& state, at::Index index, double sigma) noexcept {
  state.covariance.row(index).setZero();
  state.covariance.col(index).setZero();
  state.variance(index) = sigma * sigma;
  state.slow.sensitivity.row(index).setZero();
}

/// P + B P_s Bᵀ of pose and velocity, with the second-order effect of a heading error ψ̃ on a
/// driven path D, -½ ψ̃² D: its mean square is ¾ σ⁴ D Dᵀ, where P_Xψ = -D_y σ² and P_Yψ = D_x σ².
[[nodiscard]] inline Eigen::Matrix<double, 6, 6> covariance_of_motion(const State& state) noexcept {
  // Eigen's blocked product is slower at this size.
  const Eigen::Matrix<double, 6, slow::size> B = state.slow.sensitivity.topRows<6>();
  const Eigen::Matrix<double, 6, slow::size> with_slow = B.lazyProduct(state.slow.covariance);
  Eigen::Matrix<double, 6, 6> P =
      state.covariance.topLeftCorner<6, 6>() + with_slow.lazyProduct(B.transpose());
  const Eigen::Vector2d way(P(at::y, at::yaw), -P(at::x, at::yaw));
  P.topLeftCorner<2, 2>() += (1.0 - squared(0.5)) * way * way.transpose();
  return P;
}

}  // namespace odomd::estimator::full
