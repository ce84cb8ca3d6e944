#include "tools/identify/noise/bias_filter.hpp"

#include <algorithm>
#include <cmath>

#include "tools/math/median.hpp"

namespace odomd::tools {

FilteredBias filter_bias(const Series& series, double lambda, Direction direction,
                         std::vector<double>* innovations) {
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

std::vector<std::size_t> far_off(const Series& series, double lambda, double least) {
  std::vector<double> all;
  (void)filter_bias(series, lambda, Direction::forwards, &all);
  const double sigma = std::max(robust_sigma(all), least);
  std::vector<std::size_t> far;
  for (std::size_t i = 0; i < all.size(); ++i)
    if (std::fabs(all[i]) > 6.0 * sigma) far.push_back(i + 1);
  return far;
}

Series without(const Series& series, std::span<const std::size_t> samples) {
  Series kept;
  auto next = samples.begin();
  for (std::size_t i = 0; i < series.size(); ++i) {
    if (next != samples.end() && *next == i) {
      ++next;
      continue;
    }
    kept.add(series.t_ns[i], series.value[i]);
  }
  return kept;
}

bool are_correlated(const Series& series, double lambda) {
  std::vector<double> all;
  (void)filter_bias(series, lambda, Direction::forwards, &all);
  double squares = 0.0, products = 0.0;
  for (std::size_t i = 0; i < all.size(); ++i) {
    squares += all[i] * all[i];
    if (i > 0) products += all[i] * all[i - 1];
  }
  constexpr double much = 0.1, no_chance = 4.0;
  return products >
         squares * std::max(much, no_chance / std::sqrt(static_cast<double>(all.size())));
}

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

double scatter_within(const Series& series, std::size_t count) {
  const Series means = means_of(series, count);
  double squares = 0.0;
  for (std::size_t i = 0; i < means.size() * count; ++i)
    squares += std::pow(series.value[i] - means.value[i / count], 2);
  return squares / static_cast<double>(std::max<std::size_t>(means.size() * count, 1));
}

}  // namespace odomd::tools
