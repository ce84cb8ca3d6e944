#include "tools/identify/latency/gyro_drive.hpp"

#include <algorithm>
#include <cmath>
#include <utility>
#include <vector>

#include "tools/math/median.hpp"

namespace odomd::tools {

double two_cycles(const Series& series) {
  const double span = 1e-9 * static_cast<double>(series.t_ns.back() - series.t_ns.front());
  return std::clamp(2.0 * span / static_cast<double>(std::max<std::size_t>(series.size(), 2) - 1),
                    0.01, 0.2);
}

double white_variance(const Series& series) {
  std::vector<double> third;
  for (std::size_t i = 0; i + 3 < series.size(); ++i)
    third.push_back(std::fabs(series.value[i + 3] - 3.0 * series.value[i + 2] +
                              3.0 * series.value[i + 1] - series.value[i]));
  if (third.empty()) return 0.0;
  const double scatter = 1.4826 * median_of(std::move(third));
  return scatter * scatter / 20.0;  // 1 + 9 + 9 + 1
}

Resampled shifted(Resampled signal, double later) {
  signal.begin += later;
  return signal;
}

Resampled times(const Resampled& a, const Resampled& b) {
  return combined(a, b, [](double u, double v) { return u * v; });
}

Resampled constant(const Resampled& like) {
  Resampled one = like;
  std::ranges::fill(one.value, 1.0);
  return one;
}

Resampled smooth(const Resampled& signal, double half) {
  return mean_around(mean_around(signal, half), half);
}

SourceOffset as_offset(estimator::Source source, std::string against, const Offset& found) {
  return {source, std::move(against), found.value, found.sigma, found.explained, found.failure};
}

}  // namespace odomd::tools
