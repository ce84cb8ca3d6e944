#include "tools/identify/noise/driving_noise.hpp"

#include <Eigen/Cholesky>
#include <Eigen/Core>
#include <algorithm>
#include <array>
#include <cmath>
#include <utility>
#include <vector>

#include "tools/math/median.hpp"

namespace odomd::tools {
namespace {

constexpr std::size_t lags = 7;
using Covariances = std::array<double, lags>;

// The coefficients of a third difference, 1 -3 3 -1, correlated with themselves: white noise of
// variance 1 gives these covariances, and the differences of white noise of variance 1 (an
// encoder's roundings, of which each counts twice) those.
constexpr std::array<double, lags> of_white{20, -15, 6, -1, 0, 0, 0};
constexpr std::array<double, lags> of_increments{70, -56, 28, -8, 1, 0, 0};

/// Variances of both parts that explain the covariances best; neither is negative.
Eigen::Vector2d explain(const Covariances& covariance) {
  Eigen::Matrix<double, lags, 2> design;
  Eigen::Matrix<double, lags, 1> seen;
  for (std::size_t k = 0; k < lags; ++k) {
    const auto row = static_cast<Eigen::Index>(k);
    design(row, 0) = of_white[k];
    design(row, 1) = of_increments[k];
    seen[row] = covariance[k];
  }
  Eigen::Vector2d both = (design.transpose() * design).ldlt().solve(design.transpose() * seen);
  if (both[1] < 0.0)
    return {std::max(design.col(0).dot(seen) / design.col(0).squaredNorm(), 0.0), 0.0};
  if (both[0] < 0.0)
    return {0.0, std::max(design.col(1).dot(seen) / design.col(1).squaredNorm(), 0.0)};
  return both;
}

struct Block {
  Covariances sum{};
  std::array<double, lags> count{};
};

Covariances mean_of(const std::vector<Block>& blocks) {
  Covariances mean{};
  for (std::size_t k = 0; k < lags; ++k) {
    double sum = 0.0, count = 0.0;
    for (const Block& block : blocks) {
      sum += block.sum[k];
      count += block.count[k];
    }
    mean[k] = count > 0.0 ? sum / count : 0.0;
  }
  return mean;
}

}  // namespace

DrivingNoise driving_noise(const Series& series) {
  DrivingNoise noise;
  if (series.size() < 200) return noise;
  std::vector<std::int64_t> steps;
  for (std::size_t i = 1; i < series.size(); ++i)
    steps.push_back(series.t_ns[i] - series.t_ns[i - 1]);
  const std::int64_t usual = median_of(std::move(steps));

  // Third differences; not a number where the four samples do not follow each other.
  std::vector<double> third;
  for (std::size_t i = 0; i + 3 < series.size(); ++i) {
    bool even = true;
    for (std::size_t k = i; k <= i + 3; ++k) {
      even = even && series.value[k] != 0.0;
      if (k > i) {
        const std::int64_t step = series.t_ns[k] - series.t_ns[k - 1];
        even = even && step > usual / 2 && step < usual + usual / 2;
      }
    }
    third.push_back(even ? series.value[i + 3] - 3.0 * series.value[i + 2] +
                               3.0 * series.value[i + 1] - series.value[i]
                         : std::nan(""));
  }
  // Independent blocks: their scatter gives the uncertainty.
  constexpr std::size_t block_count = 24;
  std::vector<Block> blocks(block_count);
  for (std::size_t i = 0; i < third.size(); ++i) {
    if (std::isnan(third[i])) continue;
    Block& block = blocks[i * block_count / third.size()];
    for (std::size_t k = 0; k < lags && i + k < third.size(); ++k) {
      if (std::isnan(third[i + k])) continue;
      block.sum[k] += third[i] * third[i + k];
      block.count[k] += 1.0;
    }
    noise.samples += 1.0;
  }
  std::erase_if(blocks, [](const Block& block) { return block.count[lags - 1] < 5.0; });
  if (noise.samples < 100.0 || blocks.size() < 8) {
    noise.samples = 0.0;
    return noise;
  }
  const auto sigmas = [](const Eigen::Vector2d& part) {
    // An increment's rounding is in two samples.
    return std::array{std::sqrt(part[0] + 2.0 * part[1]), std::sqrt(part[0]),
                      std::sqrt(2.0 * part[1])};
  };
  const Covariances whole = mean_of(blocks);
  const std::array<double, 3> found = sigmas(explain(whole));
  // Jackknife
  std::array<double, 3> squares{};
  const auto n = static_cast<double>(blocks.size());
  for (std::size_t left_out = 0; left_out < blocks.size(); ++left_out) {
    std::vector<Block> others = blocks;
    others.erase(others.begin() + static_cast<std::ptrdiff_t>(left_out));
    const std::array<double, 3> without = sigmas(explain(mean_of(others)));
    for (std::size_t k = 0; k < 3; ++k)
      squares[k] += (without[k] - found[k]) * (without[k] - found[k]);
  }
  const auto measured = [&](std::size_t k) {
    return Measured{found[k], std::sqrt((n - 1.0) / n * squares[k])};
  };
  noise.sigma = measured(0);
  noise.white = measured(1);
  noise.increments = measured(2);
  const Eigen::Vector2d parts = explain(whole);
  double missed = 0.0;
  for (std::size_t k = 0; k < lags; ++k) {
    const double left = whole[k] - parts[0] * of_white[k] - parts[1] * of_increments[k];
    missed = std::max(missed, std::fabs(left));
  }
  noise.smooth = missed < 0.15 * whole[0];
  return noise;
}

}  // namespace odomd::tools
