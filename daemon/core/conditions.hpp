// The bits of odom_pose.conditions: their names, and their meaning in words.
#pragma once

#include <odom/types.h>

#include <array>
#include <cstdint>
#include <ranges>
#include <string_view>
#include <vector>

namespace odomd::daemon {

struct Condition {
  std::uint32_t bit = 0;     ///< an ODOM_COND_
  std::string_view name;     ///< as in the status document
  std::string_view meaning;  ///< one clause
};

/// In the order of their bits.
inline constexpr auto conditions = std::to_array<Condition>({
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
});

/// The conditions that are set.
[[nodiscard]] inline auto conditions_in(std::uint32_t bits) {
  return std::views::filter(
      conditions, [bits](const Condition& condition) { return (bits & condition.bit) != 0; });
}

[[nodiscard]] inline std::vector<std::string_view> condition_names(std::uint32_t bits) {
  std::vector<std::string_view> names;
  for (const Condition& condition : conditions_in(bits)) names.push_back(condition.name);
  return names;
}

}  // namespace odomd::daemon
