#include "tools/identify/noise/standing_noise.hpp"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <span>
#include <vector>

#include "tools/cli/text.hpp"
#include "tools/identify/common/measured.hpp"
#include "tools/math/least_squares.hpp"
#include "tools/math/median.hpp"

namespace odomd::tools {
namespace {

// A Kalman filter for a sensor's bias while the car is at rest, and deviations of a record from its
// model: outliers and correlated samples.

/// Variances are in units of the white noise's variance r: with λ = K²/r the bias's variance grows
/// by λ dt between samples, and the innovations' variances are r s.
struct FilteredBias {
  double log_sum = 0.0;   ///< Σ ln s
  double squares = 0.0;   ///< Σ ν²/s
  double bias = 0.0;      ///< after the last sample
  double variance = 0.0;  ///< its variance over r
};

enum class Direction : std::uint8_t { forwards, backwards };

/// `innovations`: receives ν/√s of each sample but the first.
FilteredBias filter_bias(const Series& series, double lambda,
                         Direction direction = Direction::forwards,
                         std::vector<double>* innovations = nullptr) {
  const std::size_t n = series.size();
  const auto at = [&](std::size_t i) { return direction == Direction::forwards ? i : n - 1 - i; };
  FilteredBias f;
  f.bias = series.value[at(0)];
  f.variance = 1.0;
  for (std::size_t i = 1; i < n; ++i) {
    const double dt =
        1e-9 * std::fabs(static_cast<double>(series.t_ns[at(i)] - series.t_ns[at(i - 1)]));
    f.variance += lambda * dt;
    const double s = f.variance + 1.0;
    const double innovation = series.value[at(i)] - f.bias;
    f.log_sum += std::log(s);
    f.squares += innovation * innovation / s;
    if (innovations != nullptr) innovations->push_back(innovation / std::sqrt(s));
    f.bias += f.variance / s * innovation;
    f.variance /= s;
  }
  return f;
}

std::vector<double> innovations_of(const Series& series, double lambda) {
  std::vector<double> innovations;
  innovations.reserve(series.size());
  (void)filter_bias(series, lambda, Direction::forwards, &innovations);
  return innovations;
}

/// The samples within 6 σ of the prediction. σ comes from the median of the innovations, and is at
/// least `min_sigma`.
Series without_far_samples(const Series& series, double lambda, double min_sigma) {
  const std::vector<double> innovations = innovations_of(series, lambda);
  const double sigma = std::max(robust_sigma(innovations), min_sigma);
  Series kept;
  kept.add(series.t_ns[0], series.value[0]);
  for (std::size_t i = 1; i < series.size(); ++i)
    if (std::fabs(innovations[i - 1]) <= 6.0 * sigma) kept.add(series.t_ns[i], series.value[i]);
  return kept;
}

/// Whether successive innovations are significantly correlated, by more than 0.1.
bool are_correlated(const Series& series, double lambda) {
  const std::vector<double> all = innovations_of(series, lambda);
  double squares = 0.0, products = 0.0;
  for (std::size_t i = 0; i < all.size(); ++i) {
    squares += all[i] * all[i];
    if (i > 0) products += all[i] * all[i - 1];
  }
  constexpr double much = 0.1, no_chance = 4.0;
  return products >
         squares * std::max(much, no_chance / std::sqrt(static_cast<double>(all.size())));
}

/// Means over every `count` samples.
Series means_of(const Series& series, std::size_t count) {
  Series means;
  for (std::size_t i = 0; i + count <= series.size(); i += count) {
    double sum = 0.0;
    for (std::size_t k = i; k < i + count; ++k) sum += series.value[k];
    means.add(series.t_ns[i] / 2 + series.t_ns[i + count - 1] / 2,
              sum / static_cast<double>(count));
  }
  return means;
}

/// The mean variance of samples about the mean of their group of `count`.
double scatter_within(const Series& series, std::size_t count) {
  const Series means = means_of(series, count);
  double squares = 0.0;
  for (std::size_t i = 0; i < means.size() * count; ++i)
    squares += std::pow(series.value[i] - means.value[i / count], 2);
  return squares / static_cast<double>(std::max<std::size_t>(means.size() * count, 1));
}

/// No sample is more precise than its resolution q, and the mean of mostly equal samples may be
/// anywhere within q. A bias that moves by less than a few steps shows no walk.
void allow_for_resolution(const Series& series, double duration, StandingNoise& noise) {
  const double rounding = rounding_noise(noise.resolution);
  const auto begin = std::span(series.value).first(series.size() / 10);
  noise.bias.sigma = std::hypot(noise.bias.sigma, rounding_left(begin, noise.resolution));
  if (noise.sigma.value >= rounding) return;
  noise.resolution_hides_noise = true;
  noise.sigma = {rounding, 0.5 * rounding};
  constexpr double few_steps = 10.0;
  const auto [low, high] = std::ranges::minmax(series.value);
  if (high - low > few_steps * noise.resolution) return;
  noise.walk.reset();
  noise.walk_below = std::max(noise.walk_below, noise.resolution / std::sqrt(duration));
}

/// The model fitted to a record, with its parameters.
struct Explained {
  StandingNoise noise;
  double lambda = 0.0;     ///< K²/r; its upper limit if there is no walk
  double variance = 0.0;   ///< r
  bool runs_away = false;  ///< from sample to sample, the bias changes by more than the noise
};

Explained explain(const Series& series) {
  const auto n = static_cast<double>(series.size() - 1);
  const double duration = n * series.cycle();
  // The likelihood of λ with the best r for this λ: r = Σ ν²/s / n.
  const auto variance_of = [&](double lambda) { return filter_bias(series, lambda).squares / n; };
  const auto likelihood = [&](double lambda) {
    const FilteredBias f = filter_bias(series, lambda);
    return -0.5 * (n * std::log(f.squares / n) + f.log_sum);
  };
  const auto of_log = [&](double log_lambda) { return likelihood(std::exp(log_lambda)); };
  // The search goes from a walk that reaches a thousandth of a sample's white noise over the whole
  // record to a walk that exceeds the noise between two samples.
  const double least = std::log(1e-6 / duration);
  const double most = std::log(n / duration);
  double best = least, best_value = of_log(least);
  constexpr int steps = 40;
  const double step = (most - least) / steps;
  for (int i = 1; i <= steps; ++i) {
    const double value = of_log(least + step * i);
    if (value <= best_value) continue;
    best = least + step * i;
    best_value = value;
  }
  // Between these limits the likelihood has one maximum, where its slope changes sign.
  const double low = std::max(best - step, least), high = std::min(best + step, most);
  const double h = 0.01 * (high - low);
  best = bisect(low, high, 12, [&](double x) { return of_log(x + h) > of_log(x - h); });
  best_value = of_log(best);
  const double none = likelihood(0.0);

  Explained explained;
  StandingNoise& noise = explained.noise;
  noise.sample_period = series.cycle();
  const double lambda = best_value > none ? std::exp(best) : 0.0;
  const double variance = variance_of(lambda);
  // ln L falls by 1/2 at one standard deviation; its curvature in ln r is n/2, in ln λ measured.
  constexpr double width = 0.2;
  const double curvature =
      (2.0 * best_value - of_log(best + width) - of_log(best - width)) / (width * width);
  const double log_lambda_sigma = curvature > 0.0 ? 1.0 / std::sqrt(curvature) : 1e9;
  const double d_log_variance = (std::log(variance_of(std::exp(best + width))) -
                                 std::log(variance_of(std::exp(best - width)))) /
                                (2.0 * width);
  const bool walks = best_value - none > 4.0 && log_lambda_sigma < 1.0 && best < most - step;
  const double log_variance_sigma =
      std::hypot(std::sqrt(2.0 / n), walks ? d_log_variance * log_lambda_sigma : 0.0);
  noise.sigma = {std::sqrt(variance), 0.5 * log_variance_sigma * std::sqrt(variance)};
  // K² = λ r
  if (walks) {
    const double walk = std::sqrt(lambda * variance);
    const double log_sigma =
        0.5 * std::hypot((1.0 + d_log_variance) * log_lambda_sigma, std::sqrt(2.0 / n));
    noise.walk = Measured{walk, log_sigma * walk};
  }
  const double reached = std::max(best_value, none) - 1.92;
  const double limit = bisect(lambda > 0.0 ? best : least, most, 30,
                              [&](double log_lambda) { return of_log(log_lambda) > reached; });
  noise.walk_below = std::sqrt(std::exp(limit) * variance_of(std::exp(limit)));
  // Even a walk too small to be detected adds to the bias's uncertainty.
  const double for_bias = walks ? lambda : std::exp(limit);
  const FilteredBias begin = filter_bias(series, for_bias, Direction::backwards);
  noise.bias = {begin.bias, std::sqrt(begin.variance * variance)};
  noise.resolution = resolution_of(series.value);
  noise.prediction_error = noise.sigma.value;
  allow_for_resolution(series, duration, noise);
  explained.lambda = for_bias;
  explained.variance = variance;
  explained.runs_away = best_value > none && best >= most - 4.0 * step;
  return explained;
}

/// Fits the record without its outliers, if they are few.
Explained without_outliers(Series& series) {
  Explained explained = explain(series);
  constexpr double few = 0.01;
  int outliers = 0;
  for (int round = 0; round < 4; ++round) {
    Series kept =
        without_far_samples(series, explained.lambda, rounding_noise(explained.noise.resolution));
    const std::size_t far = series.size() - kept.size();
    if (far == 0) break;
    outliers += static_cast<int>(far);
    if (static_cast<double>(far) > few * static_cast<double>(series.size())) {
      explained.noise.outliers = outliers;
      return explained;
    }
    series = std::move(kept);
    explained = explain(series);
  }
  explained.noise.outliers = outliers;
  explained.noise.outliers_left_out = outliers > 0;
  return explained;
}

/// Fits means over 2, 4, ... samples, until they are uncorrelated.
void explain_by_means(const Series& series, Explained& explained) {
  constexpr std::size_t most = 4096, min_means = 100;
  constexpr double unexplained = 0.05;  // from correlation below the detection threshold
  const auto correlated = [](const Series& samples, const Explained& model) {
    return model.runs_away || are_correlated(samples, model.lambda);
  };
  StandingNoise& noise = explained.noise;
  if (noise.resolution_hides_noise || !correlated(series, explained)) return;
  const auto enough = [&](std::size_t m) { return m <= most && series.size() / m >= min_means; };
  bool white = false;
  for (std::size_t m = 2; enough(m); m *= 2) {
    const Series means = means_of(series, m);
    const Explained by_means = explain(means);
    // The shortest means that pass the test are still slightly correlated: use twice as many
    // samples.
    const bool last = white || !enough(2 * m);
    white = !correlated(means, by_means);
    if (!last) continue;
    // A sample is no more precise than its scatter about the bias.
    const Measured& of_mean = by_means.noise.sigma;
    const double sigma = std::max(std::sqrt(scatter_within(series, m) + by_means.variance),
                                  std::sqrt(static_cast<double>(m)) * of_mean.value);
    noise.sigma = {sigma, std::hypot(of_mean.sigma / of_mean.value, unexplained) * sigma};
    noise.bias = by_means.noise.bias;
    noise.walk = by_means.noise.walk;
    noise.walk_below = by_means.noise.walk_below;
    noise.resolution_hides_noise = by_means.noise.resolution_hides_noise;
    noise.group_size = m;
    if (!noise.outliers_left_out)
      noise.outliers =
          static_cast<int>(means.size() - without_far_samples(means, by_means.lambda, 0.0).size());
    return;
  }
}

}  // namespace

StandingNoise standing_noise(const Series& series, const std::string& name) {
  if (series.size() < 200)
    refuse(
        "{}: {} samples are too few to determine noise; log at least one minute, ten "
        "for the bias's walk",
        name, series.size());
  const auto [low, high] = std::ranges::minmax(series.value);
  if (low == high)
    refuse("{}: always {}: the sensor is switched off, or its resolution hides the noise", name,
           low);
  constexpr double slowest = 2.0;
  if (series.cycle() > slowest)
    refuse("{}: a sample every {:.3g} s: are the times in ms? Divide them by 1000", name,
           series.cycle());
  Series kept = series;
  Explained explained = without_outliers(kept);
  explain_by_means(kept, explained);
  return explained.noise;
}

}  // namespace odomd::tools
