// Errors of an estimate's relative motion over a given time, and their spread.
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "tools/drive_files/trajectory.hpp"
#include "tools/evaluation/alignment.hpp"

namespace odomd::tools {

struct Spread {
  double mean = 0.0;
  double rms = 0.0;
  double max = 0.0;
};

/// Computes the spread of magnitudes that are added one by one.
class Gathered {
 public:
  void add(double magnitude) {
    sum_ += magnitude;
    squares_ += magnitude * magnitude;
    max_ = std::max(max_, magnitude);
    ++count_;
  }
  [[nodiscard]] std::size_t count() const { return count_; }
  [[nodiscard]] Spread spread() const {
    const auto n = static_cast<double>(std::max<std::size_t>(count_, 1));
    return {sum_ / n, std::sqrt(squares_ / n), max_};
  }

 private:
  double sum_ = 0.0;
  double squares_ = 0.0;
  double max_ = 0.0;
  std::size_t count_ = 0;
};

/// The horizons, from a tick of 5 ms to a second.
inline constexpr std::array<std::int64_t, 10> horizons_ns{
    5'000'000,   10'000'000,  20'000'000,  35'000'000,  50'000'000,
    100'000'000, 200'000'000, 350'000'000, 500'000'000, 1'000'000'000};

/// The time until the next camera pose: seven ticks of 5 ms.
inline constexpr std::int64_t short_horizon_ns = 35'000'000;

struct HorizonError {
  std::int64_t horizon_ns = 0;
  Spread displacement;      ///< [m]
  Spread yaw;               ///< of the yaw change [rad]
  std::size_t samples = 0;  ///< at least one
};

/// d(t) = R(ψ(t))ᵀ (p(t + T) − p(t)), each trajectory with its own heading; the error is ‖d − d̂‖.
/// Uses all pairs with t + T up to the last pair's time; horizons without any are left out.
[[nodiscard]] std::vector<HorizonError> horizon_errors(const Trajectory& reference,
                                                       const Trajectory& estimate,
                                                       std::span<const Pair> pairs);

}  // namespace odomd::tools
