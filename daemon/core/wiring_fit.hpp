// Tests whether the observations of a pair of sensors fit what one or two causes predict.
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>

#include "daemon/core/wiring_causes.hpp"

namespace odomd::daemon::wiring {

inline constexpr double alike = 0.7;       // below this correlation a gain means nothing
inline constexpr double very_alike = 0.8;  // above this correlation quantities are related

// The same fault cannot occur twice on one source, and two wrong units would explain too much.
inline bool exclude(std::uint8_t one, std::uint8_t other) noexcept {
  return other != nothing && causes[one].fault == causes[other].fault &&
         (causes[one].fault == WiringFault::unit ||
          (causes[one].sources & causes[other].sources) != 0);
}

inline bool swaps_axes(std::uint8_t cause) noexcept {
  return cause != nothing && causes[cause].fault == WiringFault::axes_swapped;
}

// The observations of a pair.
struct Seen {
  bool shows = false;
  double correlation = 0.0, gain = 0.0;
};
enum class Fit : std::uint8_t { open, fits, contradicts };

inline Fit fit(const std::array<std::uint8_t, 2>& by, const Pair& pair, const Seen& seen) noexcept {
  if (!seen.shows) return Fit::open;
  const bool swapped = swaps_axes(by[0]) || swaps_axes(by[1]);
  if (pair.relation == Relation::none || (swapped && (pair.a == ahead || pair.a == side))) {
    const bool related = std::abs(seen.correlation) > very_alike && seen.gain > 1.0 / pair.about;
    if (swapped && pair.relation == Relation::none) return related ? Fit::fits : Fit::open;
    return related ? Fit::contradicts : Fit::open;
  }
  if (std::abs(seen.correlation) < alike) return Fit::open;
  const auto factor = [&](Quantity q) { return factors[by[0]][q] * factors[by[1]][q]; };
  const Factor a = factor(pair.a), b = factor(pair.b);
  if (a.sign * b.sign == 0) return Fit::open;
  const double off = std::max(seen.gain, 1.0 / seen.gain);
  const bool same_unit = a.least == b.least && a.most == b.most;
  const bool predicted = same_unit ? off <= pair.about
                         : a.other ? off >= a.least && off <= a.most
                                   : seen.gain >= a.least / b.most && seen.gain <= a.most / b.least;
  if (predicted && (seen.correlation > 0.0) == (a.sign * b.sign > 0)) return Fit::fits;
  // Neither the same unit nor another: tyres slip, wheels spin, or the car understeers.
  return off > pair.about && off < pair.other ? Fit::open : Fit::contradicts;
}

}  // namespace odomd::daemon::wiring
