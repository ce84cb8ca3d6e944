#include "daemon/core/imu_mounting.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

#include "estimator/common/measurement.hpp"

namespace odomd::daemon {
namespace {

using estimator::Source;

can::Sample* sample_of(std::span<can::Sample> samples, Source source) noexcept {
  const auto found =
      std::ranges::find(samples, static_cast<std::uint16_t>(source), &can::Sample::channel);
  return found == samples.end() ? nullptr : &*found;
}

}  // namespace

void turn_accelerations(std::span<can::Sample> samples, double yaw) noexcept {
  can::Sample* const along = sample_of(samples, Source::accel_x);
  can::Sample* const across = sample_of(samples, Source::accel_y);
  constexpr double nobody_knows = std::numeric_limits<double>::quiet_NaN();
  const double x = along != nullptr ? along->value : nobody_knows;
  const double y = across != nullptr ? across->value : nobody_knows;
  const double c = std::cos(yaw);
  const double s = std::sin(yaw);
  if (along != nullptr) along->value = x * c - y * s;
  if (across != nullptr) across->value = x * s + y * c;
}

}  // namespace odomd::daemon
