#include "tools/tune/search.hpp"

#include <algorithm>
#include <utility>

namespace odomd::tools {
namespace {

struct Step {
  std::size_t axis = 0;
  double to = 0.0;
};

/// Both ways along each axis, as far as the cube goes.
std::vector<Step> steps_from(const Point& centre, double length) {
  std::vector<Step> steps;
  for (std::size_t axis = 0; axis < centre.size(); ++axis) {
    for (const double to :
         {std::max(centre[axis] - length, 0.0), std::min(centre[axis] + length, 1.0)})
      if (to != centre[axis]) steps.push_back({axis, to});
  }
  return steps;
}

}  // namespace

Found compass_search(const Costs& costs, Point start, const SearchSettings& settings) {
  Found best{.point = std::move(start), .cost = 0.0, .trials = 1};
  best.cost = costs(std::span(&best.point, 1)).front();

  for (double length = settings.first_step; length >= settings.last_step;) {
    const std::vector<Step> steps = steps_from(best.point, length);
    best.cut_short = best.trials + steps.size() + 1 > settings.trials;
    if (best.cut_short) break;
    std::vector<Point> polled(steps.size(), best.point);
    for (std::size_t i = 0; i < steps.size(); ++i) polled[i][steps[i].axis] = steps[i].to;
    const std::vector<double> cost = costs(polled);
    best.trials += polled.size();

    // The better of the two ways of each axis, where one helps.
    Point together = best.point;
    std::vector<double> least(best.point.size(), best.cost);
    std::size_t helped = 0;
    for (std::size_t i = 0; i < steps.size(); ++i) {
      if (cost[i] >= least[steps[i].axis]) continue;
      if (together[steps[i].axis] == best.point[steps[i].axis]) ++helped;
      least[steps[i].axis] = cost[i];
      together[steps[i].axis] = steps[i].to;
    }
    if (helped == 0) {
      length /= 2.0;
      continue;
    }
    const auto single = static_cast<std::size_t>(std::ranges::min_element(cost) - cost.begin());
    best.point = polled[single];
    best.cost = cost[single];
    if (helped > 1) {
      const double combined = costs(std::span(&together, 1)).front();
      ++best.trials;
      if (combined < best.cost) {
        best.point = std::move(together);
        best.cost = combined;
      }
    }
  }
  return best;
}

}  // namespace odomd::tools
