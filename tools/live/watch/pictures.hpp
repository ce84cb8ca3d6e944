// Small pictures from characters: a histogram of the beat in block characters; a map with the
// trail, the car and its uncertainty in braille dots.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include <odom/types.h>

#include "tools/live/line.hpp"
#include "tools/live/watch/state.hpp"

namespace odomd::tools::watch {

using Histogram = std::span<const std::uint64_t, ODOM_HISTOGRAM_BUCKETS>;

/// One column per `buckets_a_column` buckets, `rows` rows, the topmost first. Heights are
/// logarithmic, so that one late tick in a million is visible: any bucket that is not empty has at
/// least the lowest mark, the fullest reaches the top.
[[nodiscard]] std::vector<std::string> bars(Histogram histogram, std::size_t buckets_a_column,
                                            std::size_t rows, Glyphs glyphs);

/// The axis below the bars: marks at 1 us, 10, 100, 1 ms and 10 ms.
[[nodiscard]] std::string axis(std::size_t buckets_a_column, Glyphs glyphs);

/// The ellipse of a 2-D normal distribution at this number of standard deviations.
struct Ellipse {
  double long_half_axis = 0.0;   ///< [m]
  double short_half_axis = 0.0;  ///< [m]
  double direction = 0.0;        ///< angle of the long axis from x [rad], in (-pi/2, pi/2]
};

/// `covariance`: xx, xy, yy [m²].
[[nodiscard]] Ellipse ellipse_of(const std::array<double, 3>& covariance, double sigmas);

struct MapView {
  std::size_t columns = 0;
  std::size_t rows = 0;  ///< including the scale in the last one
  Glyphs glyphs = Glyphs::unicode;
};

/// x to the right, y upwards, with equal scales. Scale and section change in steps, so that the
/// picture does not move while the car does.
[[nodiscard]] Lines draw_map(const Trail& trail, const odom_pose& pose, const MapView& view);

}  // namespace odomd::tools::watch
