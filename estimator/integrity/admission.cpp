#include "estimator/integrity/admission.hpp"

#include <cstddef>
#include <stdexcept>
#include <string>
#include <utility>

namespace odomd::estimator {

void require_possible(const FilterSettings& s) {
  for (const auto& [name, value] :
       {std::pair{"vehicle.mass", s.vehicle.mass},
        {"vehicle.front_axle", s.vehicle.front_axle},
        {"vehicle.rear_axle", s.vehicle.rear_axle},
        {"vehicle.yaw_inertia", s.vehicle.yaw_inertia},
        {"vehicle.cornering_stiffness_front", s.vehicle.cornering_stiffness_front},
        {"vehicle.cornering_stiffness_rear", s.vehicle.cornering_stiffness_rear},
        {"vehicle.track_width", s.vehicle.track_width},
        {"the filter's period", s.period_s},
        {"the paper's Q[0]", s.paper.Q[0]},
        {"the paper's Q[1]", s.paper.Q[1]},
        {"the paper's Q[2]", s.paper.Q[2]},
        {"the paper's R[0]", s.paper.R[0]},
        {"the paper's R[1]", s.paper.R[1]},
        {"camera.max_latency", s.camera_max_latency_s},
        {"the camera's gate", s.camera_gate}}) {
    if (!std::isfinite(value) || value <= 0.0) {
      throw std::invalid_argument(std::string(name) + " must be a positive number");
    }
  }
  for (std::size_t i = 0; i < source_count; ++i) {
    if (!std::isfinite(s.sigma[i]) || s.sigma[i] <= 0.0) {
      throw std::invalid_argument("sigma of " + std::string(source_names[i]) +
                                  " must be a positive number");
    }
  }
  if (s.period_s < 1e-4 || s.period_s > 1.0) {
    throw std::invalid_argument("the filter's period must lie between 0.1 ms and 1 s");
  }
}

}  // namespace odomd::estimator
