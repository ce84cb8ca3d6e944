// How two signals of a drive go together: slope, offset and correlation of their smoothed courses.
#pragma once

#include <cstddef>
#include <vector>

#include "tools/identify/common/resampled.hpp"
#include "tools/identify/common/signal_log.hpp"

namespace odomd::tools {

/// y ≈ slope · x + offset, by least squares.
struct Relation {
  double slope = 0.0;
  double offset = 0.0;
  double correlation = 0.0;
  std::size_t count = 0;

  /// The two have something in common, so that the sign is certain.
  [[nodiscard]] bool clear() const;
};

[[nodiscard]] Relation relation_of(const std::vector<double>& y, const std::vector<double>& x);
/// Over the time that both have.
[[nodiscard]] Relation relation_of(const Series& y, const Series& x);

/// Several signals on one grid over the time that all have, as means over half a second: what is
/// late by less moves together. Empty if they have less than that in common.
[[nodiscard]] std::vector<Resampled> on_one_grid(const std::vector<const Series*>& signals);

}  // namespace odomd::tools
