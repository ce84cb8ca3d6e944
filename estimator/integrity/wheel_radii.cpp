// docs/model.md, "Integrity".
#include "estimator/integrity/wheel_radii.hpp"

#include <algorithm>
#include <cmath>

#include "estimator/common/wheel_place.hpp"
#include "estimator/integrity/integrated_speed.hpp"

namespace odomd::estimator::integrity {

void learn_radii(const Sensors& sensors, const Consensus& all, const Solution& base, double dt,
                 Observations& observed) noexcept {
  constexpr double learnt_s = 20.0;
  constexpr double most = 0.02;
  constexpr double load_known = 0.002;
  const double v = base.motion[of::speed];
  if (std::abs(v) < min_learning_speed) {
    return;
  }
  const double side = v * base.motion[of::yaw_rate] / gravity;
  for (const Row& row : all) {
    for (const Source wheel : wheel_sources) {
      if (row.sources != only(wheel)) {
        continue;
      }
      const double error = row.off(base.motion) * row.sigma / v;
      double& radius = observed.radius[index_of(wheel)];
      radius = std::clamp(radius + dt / learnt_s * error, -most, most);
      const double left = wheel_place(sensors.car, wheel).left;
      if (left != 0.0) {
        observed.load =
            std::clamp(observed.load - std::copysign(dt, left) * side * error, -most, most);
      }
    }
  }
  const double unknown = observed.load_sigma - load_known;
  observed.load_sigma -= std::min(2.0 * dt * side * side, 1.0) * unknown;
}

}  // namespace odomd::estimator::integrity
