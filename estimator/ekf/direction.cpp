// docs/model.md, "Gates and rejection timeouts".
#include "estimator/ekf/direction.hpp"

#include <cmath>

#include "estimator/ekf/plausibility.hpp"
#include "estimator/ekf/standstill.hpp"

namespace odomd::estimator::full {
namespace {

// Above this speed [m/s] a reversal needs two samples.
constexpr double fastest_reversal = 0.5;
// Above this speed [m/s] a car in neutral keeps its direction.
constexpr double slowest_rolling = 0.1;

}  // namespace

Verdict take_direction(const CarModel& model, State& state, const Sample& sample) noexcept {
  const Reading before = state.readings[index_of(Source::direction)];
  note_reading(state, sample);
  const double direction = sample.value[0];
  const double v_x = state.mean[at::v_x];
  if (direction == 0.0) {
    if (state.standstill.wheels_still || std::abs(v_x) < slowest_rolling) {
      state.direction = {true, sample.time_ns, direction};
    }
    return Verdict::fused;
  }
  const bool reversed = direction * (state.direction.value < 0.0 ? -1.0 : 1.0) < 0.0;
  if (reversed && state.moving && !state.standstill.standing && direction * v_x < 0.0) {
    if (std::abs(v_x) > fastest_reversal && direction * before.value <= 0.0) {
      return Verdict::gated;  // one corrupt frame does not reverse a car
    }
    state.mean.segment<6>(at::v_x) << -v_x, 0.0, state.mean[at::yaw_rate], 0.0, 0.0, 0.0;
    set_off(model, state, 2.0 * v_x);
  }
  state.direction = {true, sample.time_ns, direction};
  return Verdict::fused;
}

}  // namespace odomd::estimator::full
