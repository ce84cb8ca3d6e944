#include "tools/identify/common/resampled.hpp"

#include <algorithm>
#include <cmath>

namespace odomd::tools {

double Resampled::at(double t) const {
  const double place = std::clamp((t - begin) / step, 0.0, static_cast<double>(value.size() - 1));
  const auto i = std::min(static_cast<std::size_t>(place), value.size() - 1);
  const std::size_t next = std::min(i + 1, value.size() - 1);
  return value[i] + (place - static_cast<double>(i)) * (value[next] - value[i]);
}

Resampled resampled(const Series& series, std::int64_t origin_ns, double begin, double end,
                    double step) {
  Resampled result{begin, step, {}};
  const auto count = static_cast<std::size_t>(std::max(1.0, std::floor((end - begin) / step) + 1));
  result.value.reserve(count);
  const auto time = [&](std::size_t k) {
    return 1e-9 * static_cast<double>(series.t_ns[k] - origin_ns);
  };
  std::size_t k = 0;
  for (std::size_t i = 0; i < count; ++i) {
    const double t = begin + step * static_cast<double>(i);
    while (k + 1 < series.size() && time(k + 1) <= t) ++k;
    double value = series.value[k];
    if (k + 1 < series.size() && t > time(k))
      value += (t - time(k)) / (time(k + 1) - time(k)) * (series.value[k + 1] - value);
    result.value.push_back(value);
  }
  return result;
}

Resampled integral(const Resampled& signal) {
  Resampled result = signal;
  double sum = 0.0;
  for (std::size_t i = 0; i < signal.value.size(); ++i) {
    if (i > 0) sum += 0.5 * signal.step * (signal.value[i - 1] + signal.value[i]);
    result.value[i] = sum;
  }
  return result;
}

Resampled slope_around(const Resampled& signal, double half) {
  return on_grid_of(signal, [&](double t) {
    const double from = std::max(t - half, signal.begin);
    const double to = std::min(t + half, signal.end());
    return to > from ? (signal.at(to) - signal.at(from)) / (to - from) : 0.0;
  });
}

Resampled mean_around(const Resampled& signal, double half) {
  return slope_around(integral(signal), half);
}

}  // namespace odomd::tools
