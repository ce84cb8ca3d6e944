// Tracks, and a driver who keeps the car in a power slide.
#include <numbers>
#include <stdexcept>

#include "tests/gtest.hpp"
#include "tools/sim/car/plant.hpp"
#include "tools/sim/course/driver.hpp"
#include "tools/sim/course/track.hpp"
#include "tools/sim/simulation.hpp"

namespace odomd::sim::sim_course_test {
namespace {

using std::numbers::pi;

Track square() {
  return {rounded_polygon({{0, 0, 1}, {6, 0, 1}, {6, 6, 1}, {0, 6, 1}}, Shape::closed, 0.01),
          Shape::closed, 0.3};
}

TEST(Track, HasTheLengthAndTheCurvesOfItsPolygon) {
  const Track track = square();
  EXPECT_NEAR(track.length(), 16.0 + 2.0 * pi, 0.1);
  double turned = 0.0;
  for (std::size_t i = 1; i < track.samples().size(); ++i)
    turned += track.samples()[i].curvature * track.step();
  EXPECT_NEAR(turned, 2.0 * pi, 1e-3);
  EXPECT_NEAR(track.at(3.0 + pi / 4.0).curvature, 0.0, 0.02);
  // The track repeats after each lap.
  const TrackPoint once = track.at(1.3), again = track.at(1.3 + 3.0 * track.length());
  EXPECT_NEAR(once.x, again.x, 1e-9);
  EXPECT_NEAR(once.y, again.y, 1e-9);
  EXPECT_NEAR(once.heading + 6.0 * pi, again.heading, 1e-9);
  // The nearest point.
  const TrackPoint p = track.at(7.5);
  EXPECT_NEAR(track.nearest(p.x - 0.1 * std::sin(p.heading), p.y + 0.1 * std::cos(p.heading), 7.3),
              7.5, 0.02);
}

TEST(Track, AnOpenTrackContinuesStraight) {
  const Track track(rounded_polygon({{0, 0, 0}, {2, 0, 0}, {4, 0, 0}}, Shape::open, 0.01),
                    Shape::open, 0.3);
  EXPECT_NEAR(track.at(track.length() + 1.0).x, 5.0, 1e-6);
  EXPECT_NEAR(track.at(-1.0).x, -1.0, 1e-6);
}

TEST(Track, HasNoJumpsOfCurvature) {
  for (const Scenario& scenario : all_scenarios()) {
    const Route route = scenario.route(scenario.speed, 1);
    for (const Leg& leg : route.legs) {
      const auto& samples = leg.track->samples();
      const double wheelbase = configured_vehicle(scenario.car).wheelbase();
      for (std::size_t i = 1; i < samples.size(); ++i) {
        // The car can drive every curve, and the steering can follow every change of curvature.
        EXPECT_LT(std::abs(samples[i].curvature) * wheelbase, 0.5) << scenario.name;
        EXPECT_LT(std::abs(samples[i].curvature - samples[i - 1].curvature) * wheelbase, 0.12)
            << scenario.name << " at " << static_cast<double>(i) * leg.track->step();
      }
    }
  }
}

TEST(Driver, KeepsTheRearAxleOnTheTrack) {
  ParameterSet ideal = default_parameters(CarKind::scale_car);
  make_ideal(ideal);
  const PlantParameters car = true_vehicle(CarKind::scale_car, ideal);
  const Scenario& scenario = find_scenario("lap");
  const Leg leg = scenario.route(1.5, 1).legs.front();
  const TrackPoint start = standing_pose(car, leg);
  Plant plant(car, start.x, start.y, start.heading);
  Driver driver(car, {leg}, scenario.limits, 0.0);
  double s = 0.0, farthest = 0.0;
  for (int k = 0; !driver.done() && k < 60'000; k += 20) {
    const PlantInput input = driver.drive(plant.output(), 0.01);
    for (int i = 0; i < 20; ++i) plant.step(input, 0.0005);
    const PlantOutput& out = plant.output();
    const double x = out.x - car.rear_axle * std::cos(out.yaw);
    const double y = out.y - car.rear_axle * std::sin(out.yaw);
    s = leg.track->nearest(x, y, s);
    const TrackPoint foot = leg.track->at(s);
    farthest = std::max(farthest, std::hypot(x - foot.x, y - foot.y));
  }
  EXPECT_TRUE(driver.done());
  EXPECT_LT(farthest, 0.08);
}

constexpr double degree = std::numbers::pi / 180.0;

struct Slides {
  int left = 0, right = 0;  // curves in which the car slid by more than 30° for over 1 s
  double longest = 0.0;     // [s]
  double largest = 0.0;     // sideslip angle [rad]
  double spin = 0.0;        // largest ratio of a driven wheel's speed and the car's
  double free_wheels = 0.0;
  double countersteer = 0.0;  // largest angle of the front wheels against the curve [rad]
  double distance = 0.0;      // between start and end [m]
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

TEST(PowerSlide, SpinsTheDrivenWheelsCountersteersAndNeedsSpeed) {
  const Slides slides = slides_of({.scenario = "drift", .laps = 1});
  EXPECT_GT(slides.spin, 1.8);
  EXPECT_LT(slides.free_wheels, 1.1);  // on the outer side of the turn
  EXPECT_GT(slides.countersteer, 10.0 * degree);
  const Slides slow = slides_of({.scenario = "drift", .speed = 2.0, .laps = 1});
  EXPECT_LT(slow.largest, 10.0 * degree);
  EXPECT_LT(slow.distance, 0.02);
}

}  // namespace
}  // namespace odomd::sim::sim_course_test
