// Which of a few sensors contradict each other, and whether a single one of them is at fault.
#pragma once

#include <array>
#include <cstddef>

namespace odomd::estimator::monitor {

template <std::size_t Members>
class Contradictions {
 public:
  void add(std::size_t a, std::size_t b) noexcept {
    with_[a][b] = true;
    with_[b][a] = true;
    ++count_;
  }

  [[nodiscard]] std::size_t count() const noexcept { return count_; }
  [[nodiscard]] bool between(std::size_t a, std::size_t b) const noexcept { return with_[a][b]; }

  /// How many contradict `member`, where without it there would be no contradiction at all; else 0.
  [[nodiscard]] std::size_t explained_by(std::size_t member) const noexcept {
    std::size_t own = 0;
    for (const bool contradicts : with_[member]) {
      own += contradicts ? 1 : 0;
    }
    return own == count_ ? own : 0;
  }

 private:
  std::array<std::array<bool, Members>, Members> with_{};
  std::size_t count_ = 0;
};

}  // namespace odomd::estimator::monitor
