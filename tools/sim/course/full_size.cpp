#include "tools/sim/course/full_size.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>

#include "tools/sim/course/shapes.hpp"

namespace odomd::sim {
namespace {

TrackPointer closed(const std::vector<Corner>& corners, double smoothing) {
  return polygon(corners, Shape::closed, 0.2, smoothing);
}

TrackPointer course() {
  static const std::vector<Corner> corners{
      {80, 0, 40},   {260, 0, 45},  {330, 110, 40}, {240, 200, 25}, {170, 110, 22},
      {90, 130, 25}, {60, 240, 35}, {-70, 220, 40}, {-100, 90, 60}, {-50, 0, 40},
  };
  return closed(corners, 12.0);
}

TrackPointer open_line(const std::vector<Corner>& corners) {
  return polygon(corners, Shape::open, 0.05, 2.5);
}

}  // namespace

Route course_laps(double speed, int laps) {
  return rounds(course(), speed, laps);
}

Route course_stops(double speed, int laps) {
  constexpr std::array stretches{70.0, 30.0, 110.0, 15.0, 50.0, 130.0};
  return rounds_with_stops(course(), stretches, 10.0, speed, laps);
}

Route skid_pad(double speed, int laps) {
  return rounds(circle_through_origin(40.0, 8.0), speed, laps);
}

// Waves of 4 s: with λ = 4 s v and a_y = A (2π / λ)² v² the amplitude is the same at every speed.
Route cone_slalom(double speed, int laps) {
  constexpr double period = 4.0, lateral = 4.5;
  const double wave = period * std::max(speed, 6.0);
  const double amplitude = lateral * std::pow(period / (2.0 * std::numbers::pi), 2);
  return rounds(weaving({6.0 * wave, wave, amplitude, 44.0, 1500}, 8.0), speed, laps);
}

Route car_park(double speed, int laps) {
  return manoeuvres(
      {{open_line({{0, 0, 0}, {12, 0, 0}, {24, 0, 0}})},
       {open_line({{24, 0, 0}, {12, 0, 7}, {12, -13, 0}}), 0.5, Gear::reverse},
       {open_line({{12, -13, 0}, {12, 0, 7}, {36, 0, 0}}), 0.7},
       {open_line({{36, 0, 0}, {32, 0, 7}, {25, -3.5, 7}, {19, -3.5, 0}}), 0.5, Gear::reverse},
       {open_line({{19, -3.5, 0}, {23, -3.5, 7}, {30, 0, 7}, {37, 0, 0}}), 0.7},
       {open_line({{37, 0, 0}, {18, 0, 0}, {0, 0, 0}}), 1.0, Gear::reverse}},
      speed, laps);
}

// Two straights, and two half circles to the left that have all of the bank.
Route banked_oval(double speed, int laps) {
  return rounds(closed({{0, 0, 40}, {85, 0, 45}, {85, 91, 45}, {-85, 91, 45}, {-85, 0, 45}}, 12.0),
                speed, laps);
}

Route country_road(double speed, int laps) {
  static const std::vector<Corner> corners{
      {150, 0, 60},   {330, 0, 60},   {420, 110, 45}, {330, 190, 35}, {380, 290, 40},
      {270, 330, 40}, {200, 230, 30}, {110, 250, 35}, {90, 350, 30},  {-30, 330, 40},
      {-60, 190, 50}, {30, 110, 30},  {-50, 40, 30},  {20, 0, 40},
  };
  return rounds(closed(corners, 20.0), speed, laps);
}

}  // namespace odomd::sim
