#include "tools/sim/course/driver.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <memory>
#include <numbers>
#include <stdexcept>
#include <string>

namespace odomd::sim {
namespace {

using std::numbers::pi;
using enum CarKind;

using TrackPointer = std::shared_ptr<const Track>;
using Corners = std::vector<Corner>;
using MakeRoute = decltype(Scenario::route);

// Tracks for cars of any size.

// A line of straights between rounded corners, as points with this spacing.
struct Polygon {
  double spacing = 0.0, smoothing = 0.0;  // [m]
  Corners corners;
};
TrackPointer track_along(const Polygon& line, Shape shape) {
  return std::make_shared<Track>(rounded_polygon(line.corners, shape, line.spacing), shape,
                                 line.smoothing);
}

// A circle that starts along x; to the left for a positive radius.
TrackPointer circle_through_origin(double radius, double smoothing) {
  constexpr int points = 720;
  std::vector<Vector2> line;
  for (int k = 0; k < points; ++k) {
    const double angle = 2.0 * pi * k / points;
    line.push_back({std::abs(radius) * std::sin(angle), radius * (1.0 - std::cos(angle))});
  }
  return std::make_shared<Track>(line, Shape::closed, smoothing);
}

// Out along x in waves that fade in and out, a turn to the left, back in waves, and a turn.
struct Weave {
  double length = 0.0;     // of the outward path [m]
  double wave = 0.0;       // length of a wave [m]
  double amplitude = 0.0;  // [m]
  double gap = 0.0;        // between outward and return path [m]
  int points = 0;          // in each of the four parts
};
TrackPointer weaving(const Weave& weave, double smoothing) {
  const auto& [length, wave, amplitude, gap, points] = weave;
  std::vector<Vector2> line;
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

// Routes from a speed and a number of laps.

// Round a closed track, and a stop on the start line.
Leg rounds(const TrackPointer& track, double speed, int laps) {
  return {.track = track, .end = laps * track->length(), .speed = speed};
}

MakeRoute laps_on(const Polygon& line, const std::vector<FrictionPatch>& ice = {}) {
  return [=](double speed, int laps) -> Route {
    return {.legs = {rounds(track_along(line, Shape::closed), speed, laps)}, .patches = ice};
  };
}

MakeRoute on_a_circle(double radius, double smoothing) {
  return [=](double speed, int laps) -> Route {
    return {.legs = {rounds(circle_through_origin(radius, smoothing), speed, laps)}};
  };
}

// Laps with a stop after each of the stretches in turn [m], except within the last `least` metres
// before the end.
MakeRoute stop_and_go(const Polygon& line, const std::vector<double>& stretches, double least) {
  return [=](double speed, int laps) {
    constexpr std::array paces{0.7, 1.0, 0.5, 0.85};
    constexpr std::array pauses{1.0, 2.0, 0.5, 1.5, 3.0};
    const TrackPointer track = track_along(line, Shape::closed);
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
  };
}

// A line between corners, driven at `pace` times the speed.
struct Move {
  Corners corners;
  double pace = 1.0;
  Gear gear = Gear::forward;
};
MakeRoute manoeuvres(double spacing, double smoothing, const std::vector<Move>& moves) {
  return [=](double speed, int laps) {
    Route route;
    for (int k = 0; k < laps; ++k)
      for (const Move& move : moves) {
        const TrackPointer line = track_along({spacing, smoothing, move.corners}, Shape::open);
        route.legs.push_back({.track = line,
                              .end = line->length(),
                              .speed = move.pace * speed,
                              .pause = 0.7,
                              .gear = move.gear});
      }
    return route;
  };
}

constexpr double circle_smoothing = 0.3;

struct Circle {
  double pace = 1.0;
  double radius = 1.0;  // [m]
};

Route to_both_sides(const std::vector<Circle>& all, double top_speed, int turns) {
  Route route;
  for (const Circle& circle : all)
    for (const double side : {1.0, -1.0})
      route.legs.push_back(rounds(circle_through_origin(side * circle.radius, circle_smoothing),
                                  circle.pace * top_speed, turns));
  return route;
}

// For the cornering stiffness: steady circles, left and right, slow to fast. Each begins and ends
// at the origin, heading along x.
Route circles(double top_speed, int turns) {
  return to_both_sides({{0.3, 1.2}, {0.5, 1.6}, {0.65, 1.2}, {0.8, 1.6}, {0.9, 1.2}, {1.0, 1.6}},
                       top_speed, turns);
}

// For odom identify fit: circles and twice as many rounds of weaving, within half of the grip.
Route exercise(double top_speed, int turns) {
  Route route = to_both_sides({{0.45, 1.2}, {0.75, 1.2}, {1.0, 1.6}}, top_speed, turns);
  // As fast as steering and grip allow: a_y of 2.5 m/s² and the sharpest steered curvature.
  constexpr double frequency = 1.3, lateral = 2.5, tightest = 1.2;
  for (const double pace : {0.6, 0.8, 1.0}) {
    const double speed = pace * top_speed;
    const double wave = speed / frequency;
    const double curvature = std::min(tightest, lateral / (speed * speed));
    const double amplitude = curvature * std::pow(wave / (2.0 * pi), 2);
    route.legs.push_back(
        rounds(weaving({9.0, wave, amplitude, 3.2, 1200}, circle_smoothing), speed, 2 * turns));
  }
  return route;
}

// Out through the cones, a turn, and back through them.
Route slalom(double speed, int laps) {
  return {.legs = {rounds(weaving({12.5, 2.5, 0.25, 3.0, 1000}, 0.5), speed, laps)}};
}

// A figure of eight whose loops are driven in power slides. Starts at the crossing.
Route drift(double speed, int laps) {
  constexpr double radius = 1.8, distance = 4.5;  // of the loops' centres from the crossing
  constexpr int points = 500;
  const double angle = std::asin(radius / distance);
  const double straight = distance * std::cos(angle);
  std::vector<Vector2> line;
  for (const double side : {1.0, -1.0}) {
    const auto add_straight = [&](double way, double y) {
      line.push_back({side * way * std::cos(angle), y * way * std::sin(angle)});
    };
    for (int k = 0; k < points; ++k) add_straight(straight * k / points, -1.0);
    for (int k = 0; k < points; ++k) {
      const double turned = -angle + (pi + 2.0 * angle) * k / points;
      line.push_back({side * (distance + radius * std::sin(turned)), -radius * std::cos(turned)});
    }
    for (int k = points; k > 0; --k) add_straight(straight * k / points, 1.0);
  }
  Leg leg = rounds(std::make_shared<Track>(line, Shape::closed, 0.5), speed, laps);
  leg.slide = 55.0 * pi / 180.0;
  return {.legs = {leg}};
}

// Cones spaced for 4.5 m/s² at the speed. Each wave takes 4 s: with λ = 4 s v and a_y = A (2π / λ)²
// v² the amplitude is the same at every speed.
Route full_size_slalom(double speed, int laps) {
  constexpr double period = 4.0, lateral = 4.5;
  const double wave = period * std::max(speed, 6.0);
  const double amplitude = lateral * std::pow(period / (2.0 * pi), 2);
  return {.legs = {rounds(weaving({6.0 * wave, wave, amplitude, 44.0, 1500}, 8.0), speed, laps)}};
}

// The corners of closed tracks.

// 8 m x 5 m, like tracks of 1:10 competitions: a long straight, tight curves, an S through the
// infield. Starts on the long straight.
const Corners competition{
    {3.4, 0.0, 1.0}, {8.0, 0.0, 1.1}, {8.0, 5.0, 1.1}, {5.6, 5.0, 1.0},
    {5.2, 2.0, 1.0}, {2.6, 2.0, 1.0}, {2.4, 5.0, 1.0}, {0.0, 5.0, 1.0},
    {0.0, 3.2, 1.0}, {0.8, 1.8, 1.0}, {0.8, 0.0, 0.9},
};

// A handling course of 1.2 km: a long straight, curves of 22 to 60 m radius.
const Corners handling{
    {80, 0, 40},   {260, 0, 45},  {330, 110, 40}, {240, 200, 25}, {170, 110, 22},
    {90, 130, 25}, {60, 240, 35}, {-70, 220, 40}, {-100, 90, 60}, {-50, 0, 40},
};

// A winding country road of 1.5 km that ends at its start.
const Corners country{
    {150, 0, 60},   {330, 0, 60},   {420, 110, 45}, {330, 190, 35}, {380, 290, 40},
    {270, 330, 40}, {200, 230, 30}, {110, 250, 35}, {90, 350, 30},  {-30, 330, 40},
    {-60, 190, 50}, {30, 110, 30},  {-50, 40, 30},  {20, 0, 40},
};

// Two straights, and two half circles to the left with the full bank.
const Corners oval{{0, 0, 40}, {85, 0, 45}, {85, 91, 45}, {-85, 91, 45}, {-85, 0, 45}};

// Into a bay in reverse, out, parallel to the kerb in two moves, and back to the start in reverse.
const std::vector<Move> park{
    {{{0, 0, 0}, {1.5, 0, 0}, {3, 0, 0}}},
    {{{3, 0, 0}, {1.5, 0, 0.9}, {1.5, -1.6, 0}}, 0.6, Gear::reverse},
    {{{1.5, -1.6, 0}, {1.5, 0, 0.9}, {4.5, 0, 0}}, 0.8},
    {{{4.5, 0, 0}, {4, 0, 0.9}, {3.1, -0.5, 0.9}, {2.4, -0.5, 0}}, 0.6, Gear::reverse},
    {{{2.4, -0.5, 0}, {2.9, -0.5, 0.9}, {3.8, 0, 0.9}, {4.6, 0, 0}}, 0.8},
    {{{4.6, 0, 0}, {2.3, 0, 0}, {0, 0, 0}}, 1.0, Gear::reverse},
};
const std::vector<Move> park_full_size{
    {{{0, 0, 0}, {12, 0, 0}, {24, 0, 0}}},
    {{{24, 0, 0}, {12, 0, 7}, {12, -13, 0}}, 0.5, Gear::reverse},
    {{{12, -13, 0}, {12, 0, 7}, {36, 0, 0}}, 0.7},
    {{{36, 0, 0}, {32, 0, 7}, {25, -3.5, 7}, {19, -3.5, 0}}, 0.5, Gear::reverse},
    {{{19, -3.5, 0}, {23, -3.5, 7}, {30, 0, 7}, {37, 0, 0}}, 0.7},
    {{{37, 0, 0}, {18, 0, 0}, {0, 0, 0}}, 1.0, Gear::reverse},
};

constexpr DriverLimits brisk{.lateral = 5.0, .acceleration = 2.0, .deceleration = 2.0};
constexpr DriverLimits drifting{.lateral = 7.5, .acceleration = 3.0, .deceleration = 3.0};
constexpr DriverLimits gentle{.lateral = 3.0, .acceleration = 0.8, .deceleration = 0.8};
constexpr DriverLimits blind{.lateral = 50.0, .acceleration = 1.5, .deceleration = 1.5};
constexpr DriverLimits on_the_road{.lateral = 3.5, .acceleration = 1.8, .deceleration = 2.0};
constexpr DriverLimits on_the_course{
    .lateral = 4.7, .acceleration = 2.5, .deceleration = 3.5, .horizon = 1.0};
constexpr DriverLimits in_the_car_park{.lateral = 2.0, .acceleration = 1.0, .deceleration = 1.0};
constexpr double degree = pi / 180.0;

const std::vector<Scenario> scenarios{
    {"lap", "laps on an 8 m x 5 m competition track, back to the start line", scale_car, 1.5, 4.0,
     3, brisk, laps_on({0.01, 1.0, competition})},
    {"circle", "steady turns to the left, 1.2 m radius", scale_car, 1.0, 3.0, 5, brisk,
     on_a_circle(1.2, 0.3)},
    {"circles", "steady circles left and right, slow to fast: odom identify stiffness", scale_car,
     2.0, 3.0, 2, brisk, circles},
    {"exercise", "circles and quick weaving at several speeds: odom identify fit", scale_car, 2.0,
     3.0, 1, brisk, exercise},
    {"slalom", "weaving through cones, out and back", scale_car, 1.5, 3.0, 2, brisk, slalom},
    {"stop-and-go", "laps with stops after 0.6 to 4 m, no two alike", scale_car, 1.5, 3.0, 2, brisk,
     stop_and_go({0.01, 1.0, competition}, {2.5, 1.2, 3.4, 0.6, 1.9, 4.1}, 0.5)},
    {"parking", "into a bay and to the kerb, forward and in reverse", scale_car, 0.6, 1.5, 3,
     gentle, manoeuvres(0.01, 0.3, park)},
    {"patch", "laps with ice in two curves and on the straight", scale_car, 1.6, 3.0, 3, blind,
     laps_on({0.01, 1.0, competition},
             {{7.7, 0.4, 0.7, 0.0}, {0.4, 4.6, 0.6, 0.0}, {5.0, 0.0, 0.4, 0.0}})},
    {"drift", "a figure of eight in power slides, left and right", scale_car, 3.4, 4.0, 3, drifting,
     drift},
    {"road", "a full-size car on 1.5 km of winding road", saloon, 18.0, 30.0, 1, on_the_road,
     laps_on({0.2, 20.0, country})},
    {"hills", "a full-size car on that road, uphill, downhill and banked", bmw_320i, 18.0, 30.0, 1,
     on_the_road, laps_on({0.2, 20.0, country}), 0.05, 4.0 * degree},
    {"banked", "a full-size car on an oval, 45 m radius, with 10 degrees of bank", bmw_320i, 15.0,
     20.0, 2, on_the_course, laps_on({0.2, 12.0, oval}), 0.0, 10.0 * degree},
    {"lap", "full-size cars: laps of a handling course, up to 7 m/s2", bmw_320i, 15.0, 25.0, 2,
     on_the_course, laps_on({0.2, 12.0, handling})},
    {"circle", "full-size cars: steady turns to the left, 40 m radius", bmw_320i, 14.0, 20.0, 3,
     on_the_course, on_a_circle(40.0, 8.0)},
    {"slalom", "full-size cars: cones spaced for 4.5 m/s2", bmw_320i, 15.0, 25.0, 1, on_the_course,
     full_size_slalom},
    {"stop-and-go", "full-size cars: the course with stops after 15 to 130 m", bmw_320i, 15.0, 25.0,
     1, on_the_course,
     stop_and_go({0.2, 12.0, handling}, {70.0, 30.0, 110.0, 15.0, 50.0, 130.0}, 10.0)},
    {"parking", "full-size cars: into a bay and to the kerb", bmw_320i, 3.0, 6.0, 2,
     in_the_car_park, manoeuvres(0.05, 2.5, park_full_size)},
};

}  // namespace

std::span<const Scenario> all_scenarios() {
  return scenarios;
}

const Scenario& find_scenario(std::string_view name, std::optional<CarSize> size) {
  std::string names;
  for (const Scenario& scenario : scenarios) {
    if (size && size_of(scenario.car) != *size) continue;
    if (scenario.name == name) return scenario;
    if (names.find(scenario.name) == std::string::npos)
      names += (names.empty() ? "" : ", ") + std::string(scenario.name);
  }
  throw std::invalid_argument("no scenario \"" + std::string(name) + "\"" +
                              (size ? " for a car of this size" : "") + "; available: " + names);
}

}  // namespace odomd::sim
