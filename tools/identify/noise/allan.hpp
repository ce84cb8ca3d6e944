// The Allan deviation: how much means over τ differ from one to the next (IEEE Std 952, annex C).
#pragma once

#include <string>
#include <vector>

#include "tools/chart/drawing.hpp"
#include "tools/identify/common/signal_log.hpp"
#include "tools/identify/noise/standing_noise.hpp"

namespace odomd::tools {

struct AllanPoint {
  double tau = 0.0;        ///< [s]
  double deviation = 0.0;  ///< in the signal's unit
  double sigma = 0.0;
};

/// Overlapping, at about six τ in each power of ten, up to a fifth of the record. Samples are taken
/// to be evenly spaced; `name` is for std::invalid_argument where they are not by far.
[[nodiscard]] std::vector<AllanPoint> allan_deviation(const Series& series,
                                                      const std::string& name);

struct BiasInstability {
  Measured value;        ///< the lowest of the curve over 0.664
  double tau = 0.0;      ///< where it is [s]
  bool reached = false;  ///< the curve rises again behind it: else it is an upper limit
};
[[nodiscard]] BiasInstability bias_instability(const std::vector<AllanPoint>& curve);

struct AllanCurve {
  std::string name;  ///< "yaw_rate"
  std::string unit;
  std::vector<AllanPoint> points;
  StandingNoise noise;
};

/// A picture of each curve, with what white noise and walk would make.
[[nodiscard]] std::vector<chart::Drawing> draw(const std::vector<AllanCurve>& curves);

}  // namespace odomd::tools
