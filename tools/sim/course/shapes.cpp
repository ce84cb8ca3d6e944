#include "tools/sim/course/shapes.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>

namespace odomd::sim {

using std::numbers::pi;

TrackPointer polygon(const std::vector<Corner>& corners, Shape shape, double spacing,
                     double smoothing) {
  return std::make_shared<Track>(rounded_polygon(corners, shape, spacing), shape, smoothing);
}

TrackPointer circle_through_origin(double radius, double smoothing) {
  constexpr int points = 720;
  std::vector<Point> line;
  for (int k = 0; k < points; ++k) {
    const double angle = 2.0 * pi * k / points;
    line.push_back({std::abs(radius) * std::sin(angle), radius * (1.0 - std::cos(angle))});
  }
  return std::make_shared<Track>(line, Shape::closed, smoothing);
}

TrackPointer weaving(const Weave& weave, double smoothing) {
  const auto& [length, wave, amplitude, gap, points] = weave;
  std::vector<Point> line;
  const auto go_along = [&](int k, double y) {
    const double x = length * k / points;
    const double ends = std::min({1.0, x / wave, (length - x) / wave});  // fades in and out
    line.push_back({x, y + amplitude * ends * std::sin(2.0 * pi * x / wave)});
  };
  const auto half_turn = [&](double x, double from) {
    for (int k = 0; k < points; ++k) {
      const double angle = from + pi * k / points;
      line.push_back({x + 0.5 * gap * std::sin(angle), 0.5 * gap * (1.0 - std::cos(angle))});
    }
  };
  for (int k = 0; k < points; ++k) go_along(k, 0.0);
  half_turn(length, 0.0);
  for (int k = points; k > 0; --k) go_along(k, gap);
  half_turn(0.0, pi);
  return std::make_shared<Track>(line, Shape::closed, smoothing);
}

Route rounds(const TrackPointer& track, double speed, int laps) {
  return {.legs = {{.track = track, .end = laps * track->length(), .speed = speed}}};
}

Route rounds_with_stops(const TrackPointer& track, std::span<const double> stretches, double least,
                        double speed, int laps) {
  constexpr std::array paces{0.7, 1.0, 0.5, 0.85};
  constexpr std::array pauses{1.0, 2.0, 0.5, 1.5, 3.0};
  const double total = laps * track->length();
  Route route;
  double begin = 0.0;
  for (std::size_t k = 0; begin < total; ++k) {
    double end = begin + stretches[k % stretches.size()];
    if (end > total - least) end = total;
    route.legs.push_back({.track = track,
                          .begin = begin,
                          .end = end,
                          .speed = speed * paces[k % paces.size()],
                          .pause = pauses[k % pauses.size()]});
    begin = end;
  }
  return route;
}

Route manoeuvres(const std::vector<Move>& moves, double spacing, double smoothing, double speed,
                 int laps) {
  Route route;
  for (int k = 0; k < laps; ++k)
    for (const Move& move : moves) {
      const TrackPointer line = polygon(move.corners, Shape::open, spacing, smoothing);
      route.legs.push_back({.track = line,
                            .end = line->length(),
                            .speed = move.pace * speed,
                            .pause = 0.7,
                            .gear = move.gear});
    }
  return route;
}

}  // namespace odomd::sim
