// A value and how well it is known.
#pragma once

namespace odomd::tools {

/// A measured value and its standard uncertainty, in one unit.
struct Measured {
  double value = 0.0;
  double sigma = 0.0;
};

}  // namespace odomd::tools
