#include "tools/sim/course/exercise.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>

#include "tools/sim/course/shapes.hpp"

namespace odomd::sim {
namespace {

constexpr double smoothing = 0.3;

void append(Route& route, const Route& more) {
  route.legs.insert(route.legs.end(), more.legs.begin(), more.legs.end());
}

struct Circle {
  double pace = 1.0;
  double radius = 1.0;  // [m]
};

Route to_both_sides(std::span<const Circle> all, double top_speed, int turns) {
  Route route;
  for (const Circle& circle : all)
    for (const double side : {1.0, -1.0})
      append(route, rounds(circle_through_origin(side * circle.radius, smoothing),
                           circle.pace * top_speed, turns));
  return route;
}

}  // namespace

Route circles(double top_speed, int turns) {
  constexpr std::array<Circle, 6> all{
      {{0.3, 1.2}, {0.5, 1.6}, {0.65, 1.2}, {0.8, 1.6}, {0.9, 1.2}, {1.0, 1.6}}};
  return to_both_sides(all, top_speed, turns);
}

Route exercise(double top_speed, int turns) {
  constexpr std::array<Circle, 3> all{{{0.45, 1.2}, {0.75, 1.2}, {1.0, 1.6}}};
  Route route = to_both_sides(all, top_speed, turns);
  // As quick as steering and grip allow: a_y of 2.5 m/s², curvatures that the steering reaches.
  constexpr double frequency = 1.3, lateral = 2.5, tightest = 1.2;
  for (const double pace : {0.6, 0.8, 1.0}) {
    const double speed = pace * top_speed;
    const double wave = speed / frequency;
    const double curvature = std::min(tightest, lateral / (speed * speed));
    const double amplitude = curvature * std::pow(wave / (2.0 * std::numbers::pi), 2);
    append(route, rounds(weaving({9.0, wave, amplitude, 3.2, 1200}, smoothing), speed, 2 * turns));
  }
  return route;
}

}  // namespace odomd::sim
