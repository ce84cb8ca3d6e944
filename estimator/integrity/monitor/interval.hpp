// What a quantity was within the last fraction of a second, as an interval: two sensors that differ
// in delay and rate contradict each other only where their intervals lie apart.
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <limits>

namespace odomd::estimator::monitor {

/// Empty (`low` not a number): not known.
struct Interval {
  double low = std::numeric_limits<double>::quiet_NaN();
  double high = std::numeric_limits<double>::quiet_NaN();

  [[nodiscard]] bool known() const noexcept { return !std::isnan(low); }
  [[nodiscard]] double largest() const noexcept { return std::max(std::abs(low), std::abs(high)); }
  [[nodiscard]] Interval mirrored() const noexcept { return {-high, -low}; }
};

[[nodiscard]] inline Interval exactly(double value) noexcept {
  return {value, value};
}

[[nodiscard]] inline Interval between(double a, double b) noexcept {
  return {std::min(a, b), std::max(a, b)};
}

/// How far apart they lie; 0 where they overlap or one is not known.
[[nodiscard]] inline double gap(const Interval& a, const Interval& b) noexcept {
  if (!a.known() || !b.known()) {
    return 0.0;
  }
  return std::max({0.0, a.low - b.high, b.low - a.high});
}

/// The last rows of `Columns` quantities.
template <std::size_t Columns>
class History {
 public:
  static constexpr std::size_t capacity = 32;
  using Row = std::array<Interval, Columns>;

  void append(const Row& row) noexcept {
    newest_ = (newest_ + 1) % capacity;
    rows_[newest_] = row;
    count_ = std::min(count_ + 1, capacity);
  }

  [[nodiscard]] Row& newest() noexcept { return rows_[newest_]; }

  /// The row `age` rows before the newest, age < capacity; unknown before the first.
  [[nodiscard]] const Row& at(std::size_t age) const noexcept {
    return rows_[(newest_ + capacity - age) % capacity];
  }

  /// Over the last `length` rows; unknown where it is in one of them.
  [[nodiscard]] Interval over(std::size_t column, std::size_t length) const noexcept {
    if (count_ < length) {
      return {};
    }
    Interval all = at(0)[column];
    for (std::size_t age = 1; age < length && all.known(); ++age) {
      const Interval& one = at(age)[column];
      all = one.known() ? Interval{std::min(all.low, one.low), std::max(all.high, one.high)}
                        : Interval{};
    }
    return all;
  }

 private:
  std::array<Row, capacity> rows_{};
  std::size_t newest_ = 0;
  std::size_t count_ = 0;
};

}  // namespace odomd::estimator::monitor
