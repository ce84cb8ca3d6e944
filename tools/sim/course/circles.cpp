#include "tools/sim/course/circles.hpp"

#include <array>
#include <cmath>
#include <memory>
#include <numbers>
#include <vector>

namespace odomd::sim {

std::shared_ptr<const Track> circle_through_origin(double radius) {
  constexpr int points = 720;
  std::vector<Point> line;
  line.reserve(points);
  for (int k = 0; k < points; ++k) {
    const double angle = 2.0 * std::numbers::pi * k / points;
    line.push_back({std::abs(radius) * std::sin(angle), radius * (1.0 - std::cos(angle))});
  }
  return std::make_shared<Track>(line, Shape::closed, 0.3);
}

Route circles(double top_speed, int turns) {
  constexpr std::array radii{1.2, 1.6};
  constexpr std::array paces{0.3, 0.5, 0.65, 0.8, 0.9, 1.0};
  Route route;
  for (std::size_t k = 0; k < paces.size(); ++k) {
    for (const double side : {1.0, -1.0}) {
      const auto track = circle_through_origin(side * radii[k % radii.size()]);
      route.legs.push_back({.track = track,
                            .begin = 0.0,
                            .end = turns * track->length(),
                            .speed = paces[k] * top_speed});
    }
  }
  return route;
}

}  // namespace odomd::sim
