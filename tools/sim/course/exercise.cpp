#include "tools/sim/course/exercise.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <memory>
#include <numbers>
#include <utility>
#include <vector>

#include "tools/sim/course/circles.hpp"

namespace odomd::sim {
namespace {

using std::numbers::pi;

// Out along x in waves, a turn, and back in waves, a turn.
std::shared_ptr<const Track> weaving(double wave, double curvature) {
  constexpr double way = 9.0, gap = 3.2;
  const double amplitude = curvature * std::pow(wave / (2.0 * pi), 2);
  std::vector<Point> line;
  constexpr int points = 1200;
  const auto weave = [&](double x) {
    const double ends = std::clamp(std::min(x, way - x) / wave, 0.0, 1.0);  // fades in and out
    return amplitude * ends * std::sin(2.0 * pi * x / wave);
  };
  const auto half_turn = [&line](double x, double from) {
    for (int k = 0; k < points; ++k) {
      const double angle = from + pi * k / points;
      line.push_back({x + 0.5 * gap * std::sin(angle), 0.5 * gap * (1.0 - std::cos(angle))});
    }
  };
  for (int k = 0; k < points; ++k) line.push_back({way * k / points, weave(way * k / points)});
  half_turn(way, 0.0);
  for (int k = points; k > 0; --k)
    line.push_back({way * k / points, gap + weave(way * k / points)});
  half_turn(0.0, pi);
  return std::make_shared<Track>(line, Shape::closed, 0.3);
}

}  // namespace

Route exercise(double top_speed, int rounds) {
  Route route;
  const auto drive = [&](std::shared_ptr<const Track> track, double speed, int times) {
    const double end = times * track->length();
    route.legs.push_back({.track = std::move(track), .begin = 0.0, .end = end, .speed = speed});
  };
  struct Circle {
    double pace, radius;
  };
  for (const Circle circle : {Circle{0.45, 1.2}, Circle{0.75, 1.2}, Circle{1.0, 1.6}})
    for (const double side : {1.0, -1.0})
      drive(circle_through_origin(side * circle.radius), circle.pace * top_speed, rounds);
  // As quick as steering and grip allow: a_y of 2.5 m/s², curvatures that the steering reaches.
  constexpr double frequency = 1.3, lateral = 2.5, tightest = 1.2;
  for (const double pace : {0.6, 0.8, 1.0}) {
    const double speed = pace * top_speed;
    drive(weaving(speed / frequency, std::min(tightest, lateral / (speed * speed))), speed,
          2 * rounds);
  }
  return route;
}

}  // namespace odomd::sim
