// What is drawn, in the units of the axes.
#pragma once

namespace odomd::tools::chart {

struct Point {
  double x = 0.0;
  double y = 0.0;
};

/// A strip around a curve: low and high at x.
struct BandPoint {
  double x = 0.0;
  double low = 0.0;
  double high = 0.0;
};

}  // namespace odomd::tools::chart
