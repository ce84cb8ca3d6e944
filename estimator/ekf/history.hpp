// The states at the ticks of the window, to go back to where a sample comes late, and the one at
// work.
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
  /// The one at work among them.
  static constexpr std::size_t capacity = 64;

  /// The state as it is now, and the same to be changed: of one that is kept, a copy.
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

  /// Keeps the state as it is now, if the newest that is kept is older by `interval_ns`.
  void keep(std::int64_t interval_ns) noexcept {
    const State& before = states_[(now_ + capacity - 1) % capacity];
    kept_now_ = kept_ == 0 || now().time_ns - before.time_ns >= interval_ns;
  }

  /// Forgets all others. What becomes of the state at once is what is kept.
  [[nodiscard]] State& restart() noexcept {
    kept_ = 0;
    kept_now_ = true;
    return states_[now_];
  }

  /// If the state is not before `time_ns`: to the newest that is, or else the oldest.
  void rewind_to(std::int64_t time_ns) noexcept {
    while (now().time_ns >= time_ns && kept_ > 0) {
      now_ = (now_ + capacity - 1) % capacity;
      kept_now_ = true;
      --kept_;
    }
  }

  /// When the oldest state is that can be gone back to.
  [[nodiscard]] std::int64_t oldest_ns() const noexcept {
    return states_[(now_ + capacity - kept_) % capacity].time_ns;
  }

 private:
  std::array<State, capacity> states_{};
  std::size_t now_ = 0;
  std::size_t kept_ = 0;   ///< before the one at work, which is none of them ...
  bool kept_now_ = false;  ///< ... but is kept itself
};

}  // namespace odomd::estimator::full
