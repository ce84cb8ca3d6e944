#include "tools/sim/course/full_size.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <memory>
#include <numbers>
#include <utility>

namespace odomd::sim {
namespace {

using std::numbers::pi;
using TrackPointer = std::shared_ptr<const Track>;

Route rounds(TrackPointer track, double speed, int laps) {
  const double length = track->length();
  return {.legs = {{.track = std::move(track), .end = laps * length, .speed = speed}}};
}

TrackPointer course() {
  static const std::vector<Corner> corners{
      {80, 0, 40},   {260, 0, 45},  {330, 110, 40}, {240, 200, 25}, {170, 110, 22},
      {90, 130, 25}, {60, 240, 35}, {-70, 220, 40}, {-100, 90, 60}, {-50, 0, 40},
  };
  return std::make_shared<Track>(rounded_polygon(corners, Shape::closed, 0.2), Shape::closed, 12.0);
}

TrackPointer open_line(const std::vector<Corner>& corners) {
  return std::make_shared<Track>(rounded_polygon(corners, Shape::open, 0.05), Shape::open, 2.5);
}

}  // namespace

Route course_laps(double speed, int laps) {
  return rounds(course(), speed, laps);
}

Route course_stops(double speed, int laps) {
  const TrackPointer track = course();
  constexpr std::array stretches{70.0, 30.0, 110.0, 15.0, 50.0, 130.0};
  constexpr std::array paces{0.7, 1.0, 0.5, 0.85};
  constexpr std::array pauses{1.0, 2.0, 0.5, 1.5, 3.0};
  const double total = laps * track->length();
  Route route;
  double begin = 0.0;
  for (std::size_t k = 0; begin < total; ++k) {
    double end = begin + stretches[k % stretches.size()];
    if (end > total - 10.0) end = total;
    route.legs.push_back({.track = track,
                          .begin = begin,
                          .end = end,
                          .speed = speed * paces[k % paces.size()],
                          .pause = pauses[k % pauses.size()]});
    begin = end;
  }
  return route;
}

Route skid_pad(double speed, int laps) {
  constexpr double radius = 40.0;
  constexpr int points = 720;
  std::vector<Point> line;
  for (int k = 0; k < points; ++k) {
    const double angle = 2.0 * pi * k / points;
    line.push_back({radius * std::sin(angle), radius * (1.0 - std::cos(angle))});
  }
  return rounds(std::make_shared<Track>(line, Shape::closed, 8.0), speed, laps);
}

// Waves of 4 s: with λ = 4 s v and a_y = A (2π / λ)² v² the amplitude is the same at every speed.
Route cone_slalom(double speed, int laps) {
  constexpr double period = 4.0, lateral = 4.5, gap = 44.0;
  const double wave = period * std::max(speed, 6.0);
  const double amplitude = lateral * std::pow(period / (2.0 * pi), 2);
  const double way = 6.0 * wave;
  const auto weave = [&](double x) {
    const double ends = std::min({1.0, x / wave, (way - x) / wave});  // fades in and out
    return amplitude * ends * std::sin(2.0 * pi * x / wave);
  };
  constexpr int points = 1500;
  std::vector<Point> line;
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
  return rounds(std::make_shared<Track>(line, Shape::closed, 8.0), speed, laps);
}

Route car_park(double speed, int laps) {
  const TrackPointer past = open_line({{0, 0, 0}, {12, 0, 0}, {24, 0, 0}});
  const TrackPointer into_bay = open_line({{24, 0, 0}, {12, 0, 7}, {12, -13, 0}});
  const TrackPointer out_of_bay = open_line({{12, -13, 0}, {12, 0, 7}, {36, 0, 0}});
  const TrackPointer to_the_kerb =
      open_line({{36, 0, 0}, {32, 0, 7}, {25, -3.5, 7}, {19, -3.5, 0}});
  const TrackPointer from_the_kerb =
      open_line({{19, -3.5, 0}, {23, -3.5, 7}, {30, 0, 7}, {37, 0, 0}});
  const TrackPointer home = open_line({{37, 0, 0}, {18, 0, 0}, {0, 0, 0}});
  Route route;
  const auto drive = [&route](const TrackPointer& track, double pace, Gear gear) {
    route.legs.push_back(
        {.track = track, .end = track->length(), .speed = pace, .pause = 0.7, .gear = gear});
  };
  for (int k = 0; k < laps; ++k) {
    drive(past, speed, Gear::forward);
    drive(into_bay, 0.5 * speed, Gear::reverse);
    drive(out_of_bay, 0.7 * speed, Gear::forward);
    drive(to_the_kerb, 0.5 * speed, Gear::reverse);
    drive(from_the_kerb, 0.7 * speed, Gear::forward);
    drive(home, speed, Gear::reverse);
  }
  return route;
}

// Two straights, and two half circles to the left that have all of the bank.
Route banked_oval(double speed, int laps) {
  static const std::vector<Corner> corners{
      {0, 0, 40}, {85, 0, 45}, {85, 91, 45}, {-85, 91, 45}, {-85, 0, 45}};
  return rounds(
      std::make_shared<Track>(rounded_polygon(corners, Shape::closed, 0.2), Shape::closed, 12.0),
      speed, laps);
}

Route country_road(double speed, int laps) {
  static const std::vector<Corner> corners{
      {150, 0, 60},   {330, 0, 60},   {420, 110, 45}, {330, 190, 35}, {380, 290, 40},
      {270, 330, 40}, {200, 230, 30}, {110, 250, 35}, {90, 350, 30},  {-30, 330, 40},
      {-60, 190, 50}, {30, 110, 30},  {-50, 40, 30},  {20, 0, 40},
  };
  return rounds(
      std::make_shared<Track>(rounded_polygon(corners, Shape::closed, 0.2), Shape::closed, 20.0),
      speed, laps);
}

}  // namespace odomd::sim
