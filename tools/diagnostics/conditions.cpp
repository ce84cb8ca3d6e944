#include "tools/diagnostics/conditions.hpp"

#include <odom/types.h>

#include <algorithm>
#include <array>
#include <iterator>

namespace odomd::tools {
namespace {

constexpr std::array<Condition, 20> all{{
    {ODOM_COND_NOT_REALTIME, "not_realtime", "the machine refused real-time scheduling or locking"},
    {ODOM_COND_RESTARTED, "restarted", "resumed from the last pose"},
    {ODOM_COND_BUS_DOWN, "bus_down", "a bus is down or gone"},
    {ODOM_COND_SIGNAL_TIMEOUT, "signal_timeout", "a mapped signal is overdue"},
    {ODOM_COND_PROTECTION, "protection", "a message fails its end-to-end protection"},
    {ODOM_COND_FRAMES_LOST, "frames_lost", "the kernel dropped frames within the last second"},
    {ODOM_COND_CARRIED_OVER, "carried_over", "frames were left behind for the next tick"},
    {ODOM_COND_CLOCK_STEPPED, "clock_stepped", "the wall clock stepped within the last second"},
    {ODOM_COND_SUSPENDED, "suspended", "the machine slept within the last second"},
    {ODOM_COND_CAMERA_REJECTED, "camera_rejected",
     "the last camera pose was not plausible, too old or from the future"},
    {ODOM_COND_MODEL_FAULT, "model_fault", "the model left its valid range and stopped"},
    {ODOM_COND_NON_FINITE, "non_finite", "a state that was not finite was reset"},
    {ODOM_COND_INPUT_ENDED, "input_ended", "the log or the pipe has ended"},
    {ODOM_COND_SENSOR_FAULT, "sensor_fault", "a sensor's values are impossible: see its flag"},
    {ODOM_COND_WHEEL_SLIP, "wheel_slip", "a wheel's speed disagrees with the car's motion"},
    {ODOM_COND_MISWIRED, "miswired", "a sensor is wired or described wrongly: see its wiring"},
    {ODOM_COND_INCONSISTENT, "inconsistent",
     "a source has been inconsistent with the filter for seconds"},
    {ODOM_COND_BIAS_UNLEARNT, "bias_unlearnt",
     "the gyro's bias is not known: let the car stand for 2 s"},
    {ODOM_COND_SCALE_IMPLAUSIBLE, "scale_implausible",
     "a learnt scale is far from its configured value: check it"},
    {ODOM_COND_CAMERA_REFUSED, "camera_refused",
     "a camera connection was refused within the last ten seconds"},
}};

}  // namespace

std::vector<Condition> conditions_in(std::uint32_t bits) {
  std::vector<Condition> set;
  std::copy_if(all.begin(), all.end(), std::back_inserter(set),
               [bits](const Condition& condition) { return (bits & condition.bit) != 0; });
  return set;
}

std::optional<Condition> condition_named(std::string_view name) {
  const auto* const found =
      std::find_if(all.begin(), all.end(),
                   [name](const Condition& condition) { return condition.name == name; });
  if (found == all.end()) return std::nullopt;
  return *found;
}

}  // namespace odomd::tools
