// Power slides: the rear wheels spin, the car slides sideways for a second or more, and comes back
// to its course.
#include <algorithm>
#include <cmath>
#include <numbers>
#include <vector>

#include <gtest/gtest.h>

#include "tools/sim/simulation.hpp"

namespace odomd::sim::sim_power_slide_test {
namespace {

constexpr double degree = std::numbers::pi / 180.0;

struct Slides {
  int left = 0, right = 0;  // curves in which the car slid by more than 30° for over 1 s
  double longest = 0.0;     // [s]
  double largest = 0.0;     // sideslip angle [rad]
  double spin = 0.0;        // largest ratio of a driven wheel's speed and the car's
  double free_wheels = 0.0;
  double countersteer = 0.0;  // largest angle of the front wheels against the curve [rad]
  double distance = 0.0;      // of the end from the start [m]
  PlantOutput end;
};

Slides slides_of(const RunOptions& options) {
  const RunPlan plan = make_plan(options);
  Simulation simulation(plan);
  Slides slides;
  Happenings happenings;
  double sideslip = 0.0, duration = 0.0;
  while (simulation.advance(simulation.time_ns() + 10'000'000, happenings) == RunState::running) {
    const PlantOutput& car = simulation.plant().output();
    const double before = sideslip;
    sideslip = car.v_x > 1.0 ? std::atan2(car.v_y, car.v_x) : 0.0;
    slides.largest = std::max(slides.largest, std::abs(sideslip));
    if (std::abs(sideslip) > 30.0 * degree) {
      duration += 0.01;
      const auto ratio = [&](Wheel wheel) {
        return car.wheel_rate[wheel] * plan.car.wheel_radius[wheel] / std::hypot(car.v_x, car.v_y);
      };
      slides.spin = std::max({slides.spin, ratio(rear_left), ratio(rear_right)});
      slides.free_wheels = std::max({slides.free_wheels, ratio(front_left), ratio(front_right)});
      slides.countersteer =
          std::max(slides.countersteer, std::copysign(1.0, sideslip) * car.steering);
    } else {
      if (duration > 1.0) ++(before < 0.0 ? slides.left : slides.right);
      slides.longest = std::max(slides.longest, duration);
      duration = 0.0;
    }
  }
  slides.end = simulation.plant().output();
  slides.distance = std::hypot(slides.end.x - plan.start.x, slides.end.y - plan.start.y);
  return slides;
}

TEST(PowerSlide, IsHeldInEveryLoopAndEndsOnTheCourse) {
  for (const std::uint64_t seed : {1U, 2U, 3U, 16U, 21U}) {
    const Slides slides = slides_of({.scenario = "drift", .laps = 2, .seed = seed});
    EXPECT_EQ(slides.left, 2) << seed;
    EXPECT_EQ(slides.right, 2) << seed;
    EXPECT_LT(slides.longest, 2.0) << seed;
    EXPECT_GT(slides.largest, 45.0 * degree) << seed;
    EXPECT_LT(slides.largest, 60.0 * degree) << seed;
    EXPECT_EQ(slides.end.v_x, 0.0) << seed;
    EXPECT_LT(slides.distance, 0.15) << seed;
  }
}

TEST(PowerSlide, SpinsTheDrivenWheelsAndCountersteers) {
  const Slides slides = slides_of({.scenario = "drift", .laps = 1});
  EXPECT_GT(slides.spin, 1.8);
  EXPECT_LT(slides.free_wheels, 1.1);  // on the outer side of the turn
  EXPECT_GT(slides.countersteer, 10.0 * degree);
}

TEST(PowerSlide, NeedsSpeed) {
  const Slides slow = slides_of({.scenario = "drift", .speed = 2.0, .laps = 1});
  EXPECT_LT(slow.largest, 10.0 * degree);
  EXPECT_LT(slow.distance, 0.02);
}

}  // namespace
}  // namespace odomd::sim::sim_power_slide_test
