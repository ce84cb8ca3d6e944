// Signals on an even grid, fine enough to interpolate at any time, so that they can be compared.
#pragma once

#include <vector>

#include "tools/identify/common/signal_log.hpp"

namespace odomd::tools {

/// A signal at t = begin + k · step [s], linear in between and constant beyond its ends.
struct Resampled {
  double begin = 0.0;
  double step = 1e-3;
  std::vector<double> value;

  [[nodiscard]] double at(double t) const;
  [[nodiscard]] double end() const {
    return begin + step * static_cast<double>(value.empty() ? 0 : value.size() - 1);
  }
};

/// Interpolates linearly between the samples, whose times count from `origin_ns`.
[[nodiscard]] Resampled resampled(const Series& series, std::int64_t origin_ns, double begin,
                                  double end, double step = 1e-3);

/// The integral from the start, with the trapezoidal rule.
[[nodiscard]] Resampled integral(const Resampled& signal);

/// The mean over t ± half.
[[nodiscard]] Resampled mean_around(const Resampled& signal, double half);

/// The rate of change from t - half to t + half, which is the mean derivative there.
[[nodiscard]] Resampled slope_around(const Resampled& signal, double half);

/// f(t) on the grid of another signal.
template <class F>
[[nodiscard]] Resampled on_grid_of(const Resampled& signal, F f) {
  Resampled result = signal;
  for (std::size_t i = 0; i < signal.value.size(); ++i)
    result.value[i] = f(signal.begin + signal.step * static_cast<double>(i));
  return result;
}

/// f(a, b) for each value, on the grid of a.
template <class F>
[[nodiscard]] Resampled combined(const Resampled& a, const Resampled& b, F f) {
  return on_grid_of(a,
                    [&, i = std::size_t{0}](double t) mutable { return f(a.value[i++], b.at(t)); });
}

}  // namespace odomd::tools
