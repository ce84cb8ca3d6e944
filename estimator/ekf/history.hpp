// The states at the ticks of the window: the filter rewinds to one of them for a late sample.
//
// docs/model.md, "Late samples".
#pragma once

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>

#include "estimator/ekf/state.hpp"

namespace odomd::estimator::full {

class History {
 public:
  /// Number of states, the present one included.
  static constexpr std::size_t capacity = 64;

  /// The present state. writable() first copies it if it is kept.
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

  /// Keeps the present state if the newest kept one is older by `interval_ns`.
  void keep(std::int64_t interval_ns) noexcept {
    const State& before = states_[(now_ + capacity - 1) % capacity];
    kept_now_ = kept_ == 0 || now().time_ns - before.time_ns >= interval_ns;
  }

  /// Drops all other states. The present one is kept once it is written.
  [[nodiscard]] State& restart() noexcept {
    kept_ = 0;
    kept_now_ = true;
    return states_[now_];
  }

  /// Rewinds to the newest state before `time_ns`, or else to the oldest.
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
  std::size_t kept_ = 0;   ///< not counting the present state ...
  bool kept_now_ = false;  ///< ... which is kept itself
};

}  // namespace odomd::estimator::full
