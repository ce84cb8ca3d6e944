// The states at the ticks of the window, to which the filter rewinds for a late sample; and the
// latencies learnt from the camera, by which samples are moved earlier.
//
// docs/model.md, "Late samples".
#pragma once

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>

#include "estimator/common/measurement.hpp"
#include "estimator/common/time.hpp"
#include "estimator/ekf/state.hpp"

namespace odomd::estimator::full {

class History {
 public:
  /// Number of states, including the present one.
  static constexpr std::size_t capacity = 64;

  /// The present state. writable() first copies this state if it is to be kept.
  [[nodiscard]] const State& now() const noexcept { return states_[now_]; }
  [[nodiscard]] State& writable() noexcept {
    if (kept_now_) {
      const State& kept = now();
      now_ = (now_ + 1) % capacity;
      states_[now_] = kept;
      kept_ = std::min(kept_ + 1, capacity - 1);
      kept_now_ = false;
    }
    return states_[now_];
  }

  /// Keeps the present state if it is `reach_ns` / (capacity - 2) after the last kept one.
  void keep(std::int64_t reach_ns) noexcept {
    const std::int64_t interval_ns = reach_ns / static_cast<std::int64_t>(capacity - 2);
    const State& before = states_[(now_ + capacity - 1) % capacity];
    kept_now_ = kept_ == 0 || now().time_ns - before.time_ns >= interval_ns;
  }

  /// Drops all other states. The next writable() copies the present state and so keeps it.
  [[nodiscard]] State& restart() noexcept {
    kept_ = 0;
    kept_now_ = true;
    return states_[now_];
  }

  /// Rewinds to the newest state before `time_ns`, or to the oldest if there is none.
  void rewind_to(std::int64_t time_ns) noexcept {
    while (now().time_ns >= time_ns && kept_ > 0) {
      now_ = (now_ + capacity - 1) % capacity;
      kept_now_ = true;
      --kept_;
    }
  }

  /// Time of the oldest state to rewind to.
  [[nodiscard]] std::int64_t oldest_ns() const noexcept {
    return states_[(now_ + capacity - kept_) % capacity].time_ns;
  }

 private:
  std::array<State, capacity> states_{};
  std::size_t now_ = 0;
  std::size_t kept_ = 0;   ///< number of kept states before the present one
  bool kept_now_ = false;  ///< the present state is kept, too
};

/// A sample is moved earlier by the latency that had been learnt two windows before its own time.
/// No late sample can change that latency any more, so the order of arrival does not matter. Later
/// changes of the latency enter the sample's prediction, to first order.
class Latencies {
 public:
  explicit Latencies(std::int64_t window_ns) noexcept
      : window_ns_(std::max<std::int64_t>(window_ns, 1)) {}

  /// Uses the latencies of a state for all times.
  void begin(const State& state) noexcept { learnt_.fill(state.slow.mean); }

  /// Notes the latencies at a tick; the previous tick was at `before_ns`.
  void note(const State& state, std::int64_t before_ns) noexcept {
    if (window_of(state.time_ns) != window_of(before_ns)) {
      learnt_[place(window_of(state.time_ns))] = state.slow.mean;
    }
  }

  /// Largest time by which a sample is moved earlier: half a window.
  [[nodiscard]] std::int64_t most_ns() const noexcept { return window_ns_ / 2; }

  /// Time by which a sample taken at `time_ns` is moved earlier; never negative.
  [[nodiscard]] std::int64_t advance_ns(Source source, std::int64_t time_ns) const noexcept {
    slow::Index latency = slow::wheel_latency;
    if (source == Source::yaw_rate) {
      latency = slow::gyro_latency;
    } else if (source == Source::steering) {
      latency = slow::steering_latency;
    } else if (!is_wheel(source)) {
      return 0;
    }
    const double learnt_s = learnt_[place(window_of(time_ns) - 2)][latency];
    return std::clamp<std::int64_t>(std::llround(learnt_s * ns_per_second), 0, most_ns());
  }

 private:
  [[nodiscard]] std::int64_t window_of(std::int64_t time_ns) const noexcept {
    return time_ns / window_ns_;
  }
  [[nodiscard]] static std::size_t place(std::int64_t window) noexcept {
    return static_cast<std::uint64_t>(window) % windows;
  }

  // A sample may be a window late and needs the latencies noted two windows before.
  static constexpr std::size_t windows = 8;
  std::array<SlowVector, windows> learnt_{};
  std::int64_t window_ns_;
};

}  // namespace odomd::estimator::full
