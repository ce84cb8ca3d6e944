// docs/model.md, "Integrity".
#include "estimator/integrity/wheel_radii.hpp"

#include <algorithm>
#include <cmath>

#include "estimator/common/wheel_place.hpp"
#include "estimator/integrity/felt_speed.hpp"

namespace odomd::estimator::integrity {

void learn_radii(const Sensors& sensors, const Consensus& all, const Solution& base, double dt,
                 Heard& heard) noexcept {
  constexpr double learnt_s = 20.0;
  constexpr double most = 0.02;
  constexpr double load_known = 0.002;
  const double v = base.motion[of::speed];
  if (std::abs(v) < slowest_learning) {
    return;
  }
  const double side = v * base.motion[of::turn] / gravity;
  for (const Row& row : all) {
    for (std::size_t i = index_of(Source::wheel_front_left); i <= index_of(Source::motor); ++i) {
      if (row.sources != Sources{1} << i) {
        continue;
      }
      const double more = row.off(base.motion) * row.sigma / v;
      double& radius = heard.radius[i];
      radius = std::clamp(radius + dt / learnt_s * more, -most, most);
      const double left = wheel_place(sensors.car, static_cast<Source>(i)).left;
      if (left != 0.0) {
        heard.load = std::clamp(heard.load - std::copysign(dt, left) * side * more, -most, most);
      }
    }
  }
  const double unknown = heard.load_sigma - load_known;
  heard.load_sigma -= std::min(2.0 * dt * side * side, 1.0) * unknown;
}

}  // namespace odomd::estimator::integrity
