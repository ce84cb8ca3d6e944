// Reads the system clocks.
#include "base/wall_clock.hpp"

namespace odomd {
namespace {

constexpr int max_readings = 3;
constexpr std::int64_t close_enough_ns = 1'000;

}  // namespace

std::int64_t read_clock(clockid_t clock) noexcept {
  timespec now{};
  ::clock_gettime(clock, &now);
  return now.tv_sec * 1'000'000'000 + now.tv_nsec;
}

ClockReading read_clocks() noexcept {
  ClockReading best;
  for (int i = 0; i < max_readings; ++i) {
    ClockReading reading;
    reading.before_ns = read_clock(CLOCK_MONOTONIC);
    reading.realtime_ns = read_clock(CLOCK_REALTIME);
    reading.boottime_ns = read_clock(CLOCK_BOOTTIME);
    reading.after_ns = read_clock(CLOCK_MONOTONIC);
    const std::int64_t width = reading.after_ns - reading.before_ns;
    if (i == 0 || width < best.after_ns - best.before_ns) best = reading;
    if (width < close_enough_ns) break;
  }
  return best;
}

}  // namespace odomd
