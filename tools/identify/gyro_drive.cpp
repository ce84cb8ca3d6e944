#include "tools/identify/gyro_drive.hpp"

#include <algorithm>
#include <utility>

namespace odomd::tools {

double two_cycles(const Series& series) {
  const double span = 1e-9 * static_cast<double>(series.t_ns.back() - series.t_ns.front());
  return std::clamp(2.0 * span / static_cast<double>(std::max<std::size_t>(series.size(), 2) - 1),
                    0.01, 0.2);
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
  return mean_around(integral(mean_around(integral(signal), half)), half);
}

SourceOffset as_offset(estimator::Source source, std::string against, const Offset& found) {
  return {source, std::move(against), found.value, found.sigma, found.explained, found.doubt};
}

}  // namespace odomd::tools
