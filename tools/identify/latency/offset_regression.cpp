#include "tools/identify/latency/offset_regression.hpp"

#include <Eigen/Cholesky>
#include <Eigen/Core>
#include <algorithm>
#include <cmath>

#include "tools/cli/text.hpp"
#include "tools/math/median.hpp"

namespace odomd::tools {
namespace {

using Eigen::MatrixXd;
using Eigen::VectorXd;

constexpr double grid_step = 5e-3;
constexpr double huber = 2.0;  // in standard deviations

// The share of the apparent information on the offset that must not be noise; below it the offset
// is arbitrary.
constexpr double least_known_share = 0.5;

struct Linear {
  VectorXd coefficients;
  double cost = 0.0;
};

// Solves for y less the part of the expected coefficients, so that a prior is a ridge.
MatrixXd design(const OffsetRegression& r, double offset, std::size_t every) {
  const std::size_t rows = (r.t.size() + every - 1) / every;
  MatrixXd x(static_cast<Eigen::Index>(rows), static_cast<Eigen::Index>(r.basis.size()));
  for (std::size_t i = 0; i < rows; ++i)
    for (std::size_t j = 0; j < r.basis.size(); ++j)
      x(static_cast<Eigen::Index>(i), static_cast<Eigen::Index>(j)) =
          r.basis[j].function.at(r.t[i * every] - offset);
  return x;
}

VectorXd target(const OffsetRegression& r, std::size_t every) {
  const std::size_t rows = (r.t.size() + every - 1) / every;
  VectorXd y(static_cast<Eigen::Index>(rows));
  for (std::size_t i = 0; i < rows; ++i) y[static_cast<Eigen::Index>(i)] = r.y[i * every];
  return y;
}

// Information of the priors, for residuals of variance s² that count as one each.
void add_priors(const OffsetRegression& r, double variance, MatrixXd& a, VectorXd* b) {
  for (std::size_t j = 0; j < r.basis.size(); ++j) {
    if (!std::isfinite(r.basis[j].sigma)) continue;
    const double weight = variance / (r.basis[j].sigma * r.basis[j].sigma);
    const auto k = static_cast<Eigen::Index>(j);
    a(k, k) += weight;
    if (b != nullptr) (*b)[k] += weight * r.basis[j].expected;
  }
}

MatrixXd inverse_of(const MatrixXd& a) {
  // Scaled to a unit diagonal: the functions have different units.
  VectorXd scale = a.diagonal();
  for (Eigen::Index k = 0; k < scale.size(); ++k)
    scale[k] = scale[k] > 0.0 ? 1.0 / std::sqrt(scale[k]) : 1.0;
  MatrixXd scaled = scale.asDiagonal() * a * scale.asDiagonal();
  scaled.diagonal().array() += 1e-12;
  return scale.asDiagonal() *
         MatrixXd(scaled.ldlt().solve(MatrixXd::Identity(a.rows(), a.cols()))) * scale.asDiagonal();
}

Linear solve_linear(const OffsetRegression& r, const MatrixXd& x, const VectorXd& y,
                    double variance) {
  MatrixXd a = x.transpose() * x;
  VectorXd b = x.transpose() * y;
  add_priors(r, variance, a, &b);
  Linear result;
  result.coefficients = inverse_of(a) * b;
  result.cost = (y - x * result.coefficients).squaredNorm();
  for (std::size_t j = 0; j < r.basis.size(); ++j) {
    if (!std::isfinite(r.basis[j].sigma)) continue;
    const double off = (result.coefficients[static_cast<Eigen::Index>(j)] - r.basis[j].expected) /
                       r.basis[j].sigma;
    result.cost += variance * off * off;
  }
  return result;
}

double variance_of(const VectorXd& y) {
  return y.size() > 1 ? (y.array() - y.mean()).square().mean() : 0.0;
}

}  // namespace

Offset solve(const OffsetRegression& r) {
  Offset result;
  result.samples = r.t.size();
  if (r.t.size() < 20) {
    result.failure = "only " + counted(r.t.size(), "sample");
    return result;
  }
  const std::size_t every = std::max<std::size_t>(1, r.t.size() / 3000);
  const VectorXd thin = target(r, every);
  const double spread = variance_of(thin);
  if (!(spread > 0.0)) {
    result.failure = "the signal never changes";
    return result;
  }
  // The noise, to weigh the priors by: first a guess, then from the best of the grid.
  double noise = 0.05 * spread;
  double best_offset = 0.0;
  for (int pass = 0; pass < 2; ++pass) {
    double best = std::numeric_limits<double>::infinity();
    const int steps = static_cast<int>(std::lround(r.range / grid_step));
    MatrixXd best_x;
    Linear best_fit;
    for (int k = -steps; k <= steps; ++k) {
      MatrixXd x = design(r, k * grid_step, every);
      Linear fit = solve_linear(r, x, thin, noise);
      if (fit.cost >= best) continue;
      best = fit.cost;
      best_offset = k * grid_step;
      best_x = std::move(x);
      best_fit = std::move(fit);
    }
    const double scatter =
        1.4826 * median_of_magnitudes(VectorXd(thin - best_x * best_fit.coefficients));
    noise = std::max(scatter * scatter, 1e-12 * spread);
  }

  // Gauss-Newton over offset and coefficients together, outliers weighed down.
  const VectorXd y = target(r, 1);
  const auto rows = y.size();
  const auto basis = static_cast<Eigen::Index>(r.basis.size());
  double offset = best_offset;
  VectorXd weight = VectorXd::Ones(rows);
  VectorXd coefficients, residual;
  MatrixXd a, jacobian;
  for (int iteration = 0; iteration < 12; ++iteration) {
    const MatrixXd x = design(r, offset, 1);
    if (iteration == 0) coefficients = solve_linear(r, x, y, noise).coefficients;
    constexpr double h = 4e-3;
    const VectorXd rate =
        (design(r, offset + h, 1) - design(r, offset - h, 1)) / (2.0 * h) * coefficients;
    jacobian.resize(rows, basis + 1);
    jacobian << x, rate;
    residual = y - x * coefficients;
    const double scatter = 1.4826 * median_of_magnitudes(residual);
    noise = std::max(scatter * scatter, 1e-12 * spread);
    for (Eigen::Index i = 0; i < rows; ++i)
      weight[i] =
          std::min(1.0, huber * std::sqrt(noise) / std::max(std::fabs(residual[i]), 1e-300));
    a = jacobian.transpose() * weight.asDiagonal() * jacobian;
    VectorXd b = jacobian.transpose() * (weight.array() * residual.array()).matrix();
    for (Eigen::Index j = 0; j < basis; ++j) {
      const BasisFunction& function = r.basis[static_cast<std::size_t>(j)];
      if (std::isfinite(function.sigma))
        b[j] += noise / (function.sigma * function.sigma) * (function.expected - coefficients[j]);
    }
    MatrixXd with_priors = a;
    add_priors(r, noise, with_priors, nullptr);
    const VectorXd step = inverse_of(with_priors) * b;
    coefficients += step.head(basis);
    const double move = std::clamp(step[basis], -0.02, 0.02);
    offset += move;
    if (iteration > 3 && std::fabs(move) < 1e-7) break;
  }
  result.value = offset;
  result.coefficients.assign(coefficients.data(), coefficients.data() + basis);
  result.explained = std::max(0.0, 1.0 - noise / spread);

  // B = Σ over blocks (Σ w x e)(Σ w x e)ᵀ; the priors are information of their own.
  MatrixXd b = MatrixXd::Zero(basis + 1, basis + 1);
  VectorXd score = VectorXd::Zero(basis + 1);
  double block_end = r.t.front() + r.block;
  std::size_t blocks = 0;
  const auto close_block = [&] {
    b += score * score.transpose();
    score.setZero();
    ++blocks;
  };
  for (Eigen::Index i = 0; i < rows; ++i) {
    const double t = r.t[static_cast<std::size_t>(i)];
    if (t >= block_end) {
      close_block();
      while (t >= block_end) block_end += r.block;
    }
    score += weight[i] * residual[i] * jacobian.row(i).transpose();
  }
  close_block();
  MatrixXd with_priors = a;
  add_priors(r, noise, with_priors, nullptr);
  const MatrixXd bread = inverse_of(with_priors);
  const MatrixXd prior_part = noise * (with_priors - a);
  const double few_blocks =
      blocks > 4 ? static_cast<double>(blocks) / (static_cast<double>(blocks) - 2.0) : 4.0;
  const MatrixXd sandwich = bread * (few_blocks * b + prior_part) * bread;
  const double naive = noise * bread(basis, basis);
  const double known_share = 1.0 - weight.sum() * result.coefficients[0] * result.coefficients[0] *
                                       r.slope_noise * bread(basis, basis);
  result.sigma = std::sqrt(std::max(sandwich(basis, basis), naive)) / std::max(known_share, 0.1);

  if (std::fabs(offset) > r.range - 2.0 * grid_step)
    result.failure = "no offset within " + fixed(r.range, 1) + " s makes them agree";
  else if (known_share < least_known_share)
    result.failure =
        "too little excitation compared with the noise; drive with more turns and stops";
  else if (result.explained < 0.3)
    result.failure = "the two signals have too little in common: excitation, sign, mapping?";
  return result;
}

}  // namespace odomd::tools
