// Converts the hardware stamps of a CAN controller to CLOCK_MONOTONIC.
//
// The device clock has its own origin and drifts. Each frame also has a software stamp, which is
// later than the true instant by a latency l >= 0, so
//     software - hardware = offset + l
// and the smallest recent difference is the best guess at the offset. The minimum leaks upwards
// faster than any crystal drifts, so it follows slow and fast device clocks; the remaining error is
// the smallest latency, some microseconds.
#pragma once

#include <algorithm>
#include <cstdint>

namespace odomd::can {

/// Real-time safe. Reads no clock itself. For use by one thread.
class DeviceClock {
 public:
  /// The rate of the leak; two crystals differ by less than 100 parts per million.
  static constexpr std::int64_t drift_per_million = 200;
  /// When the device clock jumps ahead, the minimum falls immediately. When it jumps back, all
  /// differences grow, and the smallest difference in a window replaces the minimum.
  static constexpr std::int64_t window_ns = 1'000'000'000;
  /// A larger excess over the minimum cannot be a latency: the conversion restarts.
  static constexpr std::int64_t restart_ns = 1'000'000'000;

  /// The hardware stamp on CLOCK_MONOTONIC: never after `software_ns`, the software stamp of the
  /// same frame on CLOCK_MONOTONIC.
  std::int64_t to_monotonic(std::int64_t hardware_ns, std::int64_t software_ns) noexcept {
    const std::int64_t difference = software_ns - hardware_ns;
    const std::int64_t elapsed =
        std::clamp<std::int64_t>(software_ns - last_ns_, 0, longest_leak_ns);
    offset_ns_ += elapsed * drift_per_million / 1'000'000;
    last_ns_ = software_ns;

    if (!running_ || difference - offset_ns_ > restart_ns) {
      running_ = true;
      offset_ns_ = difference;
      begin_window(difference);
      return software_ns;
    }
    offset_ns_ = std::min(offset_ns_, difference);
    window_minimum_ns_ = std::min(window_minimum_ns_, difference);
    ++window_frames_;
    if (software_ns - window_start_ns_ >= window_ns || software_ns < window_start_ns_) {
      if (window_frames_ >= enough_frames) offset_ns_ = std::max(offset_ns_, window_minimum_ns_);
      offset_ns_ = std::min(offset_ns_, difference);
      begin_window(difference);
    }
    return hardware_ns + offset_ns_;
  }

 private:
  static constexpr std::int64_t longest_leak_ns = 3'600'000'000'000;
  static constexpr int enough_frames = 8;

  void begin_window(std::int64_t difference) noexcept {
    window_start_ns_ = last_ns_;
    window_minimum_ns_ = difference;
    window_frames_ = 0;
  }

  bool running_ = false;
  std::int64_t offset_ns_ = 0;  // software - hardware, without the latency
  std::int64_t last_ns_ = 0;
  std::int64_t window_start_ns_ = 0;
  std::int64_t window_minimum_ns_ = 0;
  int window_frames_ = 0;
};

}  // namespace odomd::can
