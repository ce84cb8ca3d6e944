// The car as a late sensor sees it: its outputs over the last while.
#pragma once

#include <cstdint>
#include <deque>

#include "tools/sim/car/plant_output.hpp"

namespace odomd::sim {

class PastOutputs {
 public:
  /// Keeps outputs for `reach_ns` before the second newest.
  explicit PastOutputs(std::int64_t reach_ns) : reach_ns_(reach_ns) {}

  /// Times must rise.
  void add(std::int64_t time_ns, const PlantOutput& output);

  [[nodiscard]] bool empty() const { return past_.empty(); }

  /// Interpolated, at times up to the newest. Before the first output the car was as it is there,
  /// with wheels that turned as fast.
  [[nodiscard]] PlantOutput at(std::int64_t time_ns) const;

 private:
  struct Past {
    std::int64_t time_ns = 0;
    PlantOutput output;
  };

  std::int64_t reach_ns_;
  std::deque<Past> past_;
};

}  // namespace odomd::sim
