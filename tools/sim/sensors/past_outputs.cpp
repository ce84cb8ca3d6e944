#include "tools/sim/sensors/past_outputs.hpp"

#include <algorithm>
#include <iterator>

namespace odomd::sim {
namespace {

double seconds(std::int64_t ns) {
  return 1e-9 * static_cast<double>(ns);
}

}  // namespace

void PastOutputs::add(std::int64_t time_ns, const PlantOutput& output) {
  while (past_.size() > 2 && past_[1].time_ns < past_.back().time_ns - reach_ns_) past_.pop_front();
  past_.push_back({time_ns, output});
}

PlantOutput PastOutputs::at(std::int64_t time_ns) const {
  const auto to = std::ranges::lower_bound(past_, time_ns, {}, &Past::time_ns);
  if (to == past_.begin()) {
    PlantOutput first = to->output;
    for (std::size_t wheel = 0; wheel < wheel_count; ++wheel)
      first.wheel_angle[wheel] += first.wheel_rate[wheel] * seconds(time_ns - to->time_ns);
    return first;
  }
  const auto from = std::prev(to);
  return interpolate(from->output, to->output,
                     seconds(time_ns - from->time_ns) / seconds(to->time_ns - from->time_ns));
}

}  // namespace odomd::sim
