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
  std::vector<double> squares;
  squares.reserve(all.size());
  for (const double innovation : all) squares.push_back(innovation * innovation);
  constexpr double median_of_chi_square = 0.4549;
  const double variance = std::max(median_of(std::move(squares)) / median_of_chi_square, least);
  std::vector<std::size_t> far;
  for (std::size_t i = 0; i < all.size(); ++i)
    if (all[i] * all[i] > 36.0 * variance) far.push_back(i + 1);
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

bool hang_together(const Series& series, double lambda) {
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

std::optional<Jump> find_jump(const Series& series, double variance, double walk) {
  std::vector<double> sum(series.size() + 1, 0.0);
  for (std::size_t i = 0; i < series.size(); ++i)
    sum[i + 1] = sum[i] + series.value[i] - series.value.front();
  const double span = 1e-9 * static_cast<double>(series.t_ns.back() - series.t_ns.front());
  const double period = span / static_cast<double>(series.size() - 1);
  constexpr double too_far = 6.0;
  double farthest = too_far;
  std::optional<Jump> jump;
  for (const double seconds : {1.0, 4.0, 16.0}) {
    const auto n = static_cast<std::size_t>(std::max(20.0, std::round(seconds / period)));
    if (4 * n > series.size()) break;
    const auto count = static_cast<double>(n);
    // Consecutive means over w differ by a variance of 2 r/n from noise and K² 2 w/3 from the walk.
    const double expected =
        std::sqrt(2.0 * variance / count + walk * walk * 2.0 / 3.0 * count * period);
    for (std::size_t i = n; i + n <= series.size(); ++i) {
      const double size = (sum[i + n] - 2.0 * sum[i] + sum[i - n]) / count;
      if (std::fabs(size) <= farthest * expected) continue;
      farthest = std::fabs(size) / expected;
      jump = Jump{1e-9 * static_cast<double>(series.t_ns[i] - series.t_ns.front()), size};
    }
  }
  return jump;
}

}  // namespace odomd::tools
