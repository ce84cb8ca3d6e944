#include "tools/identify/noise/bias_filter.hpp"

#include <cmath>

namespace odomd::tools {
namespace {

template <typename Take>
FilteredBias run(const Series& series, double lambda, Direction direction, Take&& take) {
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
    take(innovation, s, f);
    f.bias += f.variance / s * innovation;
    f.variance /= s;
  }
  return f;
}

}  // namespace

FilteredBias filter_bias(const Series& series, double lambda, Direction direction) {
  return run(series, lambda, direction, [](double innovation, double s, FilteredBias& f) {
    f.log_sum += std::log(s);
    f.squares += innovation * innovation / s;
  });
}

std::vector<double> innovations(const Series& series, double lambda) {
  std::vector<double> all;
  all.reserve(series.size());
  (void)run(series, lambda, Direction::forwards,
            [&all](double innovation, double s, const FilteredBias&) {
              all.push_back(innovation / std::sqrt(s));
            });
  return all;
}

}  // namespace odomd::tools
