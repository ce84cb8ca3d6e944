// A search for the least of a function that is costly, noisy at its finest and without
// derivatives: compass search (Kolda, Lewis, Torczon, SIAM Review 45, 2003), whose trials of one
// round do not wait for each other.
#pragma once

#include <cstddef>
#include <functional>
#include <span>
#include <vector>

namespace odomd::tools {

/// In the unit cube.
using Point = std::vector<double>;

/// The cost of each point; infinite where it is impossible.
using Costs = std::function<std::vector<double>(std::span<const Point>)>;

struct SearchSettings {
  double first_step = 0.25;  ///< of each range
  double last_step = 0.02;   ///< ends below it
  std::size_t trials = 400;  ///< ends when they are used up
};

struct Found {
  Point point;
  double cost = 0.0;
  std::size_t trials = 0;
  bool cut_short = false;  ///< by SearchSettings::trials
};

/// Each round tries a step either way along every axis, and then all steps that helped at once;
/// goes to the best of them, or halves the step where none helped. The same costs give the same
/// search.
[[nodiscard]] Found compass_search(const Costs& costs, Point start, const SearchSettings& settings);

}  // namespace odomd::tools
