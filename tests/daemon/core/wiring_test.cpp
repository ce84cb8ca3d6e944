// A small car that weaves, with each kind of wrong wiring.
#include "daemon/core/wiring.hpp"

#include <functional>
#include <map>
#include <numbers>

#include "tests/allocation_count.hpp"
#include "tests/gtest.hpp"

namespace odomd::daemon::wiring_test {
namespace {

using estimator::Source;
using enum estimator::Source;

using Samples = std::map<Source, double>;
using Mistake = std::function<void(Samples&)>;

constexpr estimator::Vehicle car{};
constexpr std::int64_t step_ns = 10'000'000;

struct Motion {
  double speed = 0.0, acceleration = 0.0, turn = 0.0;
};

using Course = std::function<Motion(double t)>;

Motion weaving(double t) {
  return {1.5 + 0.9 * std::sin(0.8 * t), 0.72 * std::cos(0.8 * t), 1.2 * std::sin(1.1 * t)};
}
Motion backwards(double t) {
  const Motion ahead = weaving(t);
  return {-0.4 * ahead.speed, -0.4 * ahead.acceleration, ahead.turn};
}
Course steady(double speed, double turn) {
  return [=](double) { return Motion{speed, 0.0, turn}; };
}
const Course standing = steady(0.0, 0.0), straight_on = steady(1.5, 0.0);

// Readings of correct sensors. Each wheel has the speed at its position; front wheels have the
// speed along the wheel.
Samples sensed(const Motion& motion) {
  const auto [v, a, turn] = motion;
  const double front = std::copysign(std::hypot(v, car.wheelbase() * turn), v);
  const double side = 0.5 * car.track_width * turn;
  return {{yaw_rate, turn + 0.01},
          {accel_x, a + 0.3},
          {accel_y, v * turn - 0.3},
          {wheel_front_left, front - side},
          {wheel_front_right, front + side},
          {wheel_rear_left, v - side},
          {wheel_rear_right, v + side},
          {steering, v == 0.0 ? 0.0 : std::atan(car.wheelbase() * turn / v) + 0.02}};
}

void none(Samples&) {}
Mistake factor(const std::vector<Source>& sources, double by) {
  return [=](Samples& samples) {
    for (const Source source : sources) samples[source] *= by;
  };
}
Mistake swapped(Source a, Source b) {
  return [=](Samples& samples) { std::swap(samples[a], samples[b]); };
}
Mistake both(const Mistake& a, const Mistake& b) {
  return [=](Samples& samples) { a(samples), b(samples); };
}

class Drive {
 public:
  void go(double seconds, const Mistake& mistake, const Course& course = weaving) {
    for (int k = 0; k < std::lround(100.0 * seconds); ++k) {
      t_ns += step_ns;
      const Motion now = course(t());
      yaw_ += 1e-2 * now.turn;
      x_ += 1e-2 * now.speed * std::cos(yaw_);
      y_ += 1e-2 * now.speed * std::sin(yaw_);
      Samples samples = sensed(now);
      mistake(samples);
      for (const auto& [source, value] : samples) wiring.add_sample(source, t_ns, value);
      wiring.update(t_ns);
    }
  }
  /// Adds a camera pose of the car; `side` -1: mirrored.
  void see(double side) {
    wiring.add_pose(
        estimator::CameraPose{.capture_ns = t_ns, .x = x_, .y = side * y_, .yaw = side * yaw_});
  }
  [[nodiscard]] double t() const { return 1e-9 * static_cast<double>(t_ns - begin_ns); }
  /// The faults: "yaw_rate sign, steering unit".
  [[nodiscard]] std::string found() const {
    std::string found;
    for (std::size_t source = 0; source < estimator::source_count; ++source)
      if (const WiringFault fault = wiring.fault(source); fault != WiringFault::none)
        found += (found.empty() ? "" : ", ") + std::string{estimator::source_names[source]} + ' ' +
                 std::string{wiring_names[static_cast<std::size_t>(fault)]};
    return found;
  }

  static constexpr std::int64_t begin_ns = 1'760'000'000'000'000'000;
  std::int64_t t_ns = begin_ns;
  Wiring wiring{car};

 private:
  double x_ = 0.0, y_ = 0.0, yaw_ = 0.0;
};

TEST(Wiring, FindsNoFaultInASoundCar) {
  Drive drive;
  for (const Course& course : {Course{weaving}, standing, Course{backwards}, straight_on}) {
    drive.go(40.0, none, course);
    EXPECT_EQ(drive.found(), "");
  }
}

const std::vector<Source> wheels{wheel_front_left, wheel_front_right, wheel_rear_left,
                                 wheel_rear_right};
std::string of_wheels(const std::string& fault) {
  return "wheel_front_left " + fault + ", wheel_front_right " + fault + ", wheel_rear_left " +
         fault + ", wheel_rear_right " + fault;
}

// With one wheel and no accelerometer it is unknown whether gyro or steering is wrong.
void one_of_two_turned(Samples& samples) {
  for (const Source source :
       {accel_x, accel_y, wheel_front_left, wheel_front_right, wheel_rear_left})
    samples.erase(source);
  samples[yaw_rate] *= -1.0;
}
void reversing(Samples& samples) {
  samples[direction] = -1.0;
}

TEST(Wiring, ReportsAFaultUntilItIsGone) {
  const auto front = swapped(wheel_front_left, wheel_front_right),
             rear = swapped(wheel_rear_left, wheel_rear_right),
             left = swapped(wheel_front_left, wheel_rear_left),
             right = swapped(wheel_front_right, wheel_rear_right);
  const std::string swap = "left_right_swapped", axes = "axes_swapped";
  struct Case {
    Mistake mistake;
    std::string found;
    double seconds = 25.0;  ///< time limit
  };
  const Case cases[]{
      {factor({yaw_rate}, -1.0), "yaw_rate sign"},
      {factor({yaw_rate}, 57.3), "yaw_rate unit"},  // in degrees
      {factor({yaw_rate}, 1 / 57.3), "yaw_rate unit"},
      {factor({steering}, -1.0), "steering sign", 50.0},
      {factor({steering}, 57.3), "steering unit", 50.0},
      {front, "wheel_front_left " + swap + ", wheel_front_right " + swap},
      {rear, "wheel_rear_left " + swap + ", wheel_rear_right " + swap},
      {both(front, rear), of_wheels(swap)},
      {both(left, right), of_wheels("front_rear_swapped")},
      {factor({wheel_front_right}, -1.0), "wheel_front_right sign"},
      {factor(wheels, 3.6), of_wheels("unit")},  // in km/h
      {factor(wheels, -1.0), of_wheels("sign")},
      {factor({accel_x}, -1.0), "accel_x sign"},
      {factor({accel_y}, -1.0), "accel_y sign"},
      {factor({accel_x, accel_y}, 1 / 9.81), "accel_x unit, accel_y unit"},  // in g
      {swapped(accel_x, accel_y), "accel_x " + axes + ", accel_y " + axes},
      {factor({accel_x}, 1 / 9.81), "accel_x unit"},
      {factor({accel_y}, 1 / 9.81), "accel_y unit"},
      {factor({wheel_front_left, wheel_rear_left}, -1.0),
       "wheel_front_left sign, wheel_rear_left sign"},
      {factor({wheel_front_right, wheel_rear_right}, -1.0),
       "wheel_front_right sign, wheel_rear_right sign"},
      {factor({wheel_rear_left}, 7.5), "wheel_rear_left unit"},  // without its gear ratio
      {factor({wheel_rear_left}, 2.0), "wheel_rear_left unit"},  // diameter for radius
      {both(factor({steering}, -1.0), factor({accel_x, accel_y}, 1 / 9.81)),
       "accel_x unit, accel_y unit, steering sign", 50.0},
      {one_of_two_turned, "yaw_rate sign, steering sign", 37.0},
      {reversing, of_wheels("sign") + ", direction sign", 37.0}};
  for (const auto& [mistake, found, seconds] : cases) {
    SCOPED_TRACE(found);
    Drive drive;
    drive.go(3.0, mistake);
    EXPECT_EQ(drive.found(), "") << "too early";
    drive.go(seconds, mistake);
    EXPECT_EQ(drive.found(), found);
    drive.go(60.0, mistake, standing);
    drive.go(60.0, mistake, straight_on);
    EXPECT_EQ(drive.found(), found) << "held where nothing shows";
    drive.go(60.0, mistake);
    EXPECT_EQ(drive.found(), found);
    drive.go(150.0, none);
    EXPECT_EQ(drive.found(), "");
  }
}

TEST(Wiring, IgnoresAFaultOfAFewSeconds) {
  Drive drive;
  drive.go(30.0, none);
  drive.go(3.0, factor({yaw_rate}, -1.0));
  EXPECT_EQ(drive.found(), "");
  drive.go(30.0, none);
  EXPECT_EQ(drive.found(), "");
}

void without_sign(Samples& samples) {
  for (const Source wheel : wheels) samples[wheel] = std::abs(samples[wheel]);
}

// Unsigned wheels in reverse look like a gyro with the wrong sign.
TEST(Wiring, DoesNotMistakeReversingWithUnsignedWheelsForAWrongSign) {
  Drive drive;
  drive.go(40.0, without_sign, backwards);
  EXPECT_EQ(drive.found(), "");
  drive.go(60.0, both(both(without_sign, reversing), factor({yaw_rate}, -1.0)), backwards);
  EXPECT_EQ(drive.found(), "yaw_rate sign") << "with the gear it shows";
}

// The car drives forwards and backwards between standstills, and only the motor speed is signed.
TEST(Wiring, TakesTheDirectionOfUnsignedWheelsFromASignedMotor) {
  const Mistake motor_knows = [](Samples& samples) {
    samples[motor] = 0.5 * (samples[wheel_rear_left] + samples[wheel_rear_right]);
    without_sign(samples);
  };
  Drive drive;
  for (const auto motion : {weaving, backwards, weaving, backwards}) {
    drive.go(40.0, motor_knows, motion);
    EXPECT_EQ(drive.found(), "");
  }
}

TEST(Wiring, FindsOtherFaultsNextToAMotorWithoutItsGearRatio) {
  const Mistake geared = [](Samples& samples) {
    samples[motor] = 7.5 * 0.5 * (samples[wheel_rear_left] + samples[wheel_rear_right]);
  };
  Drive drive;
  drive.go(40.0, both(geared, factor({yaw_rate}, -1.0)));
  EXPECT_EQ(drive.found(), "yaw_rate sign, motor unit");
}

TEST(Wiring, ComparesTheCamera) {
  Drive drive;
  for (int k = 0; k < 1000; ++k) {
    drive.see(-1.0);
    drive.go(0.04, none);
  }
  EXPECT_EQ(drive.found(), "camera sign");
}

TEST(Wiring, SurvivesTimeJumpsAndNonFiniteSamples) {
  constexpr std::int64_t hour_ns = 3'600'000'000'000;
  Drive drive;
  drive.go(20.0, factor({yaw_rate}, std::nan("")));
  drive.t_ns += hour_ns;
  drive.go(20.0, none);
  drive.wiring.add_sample(yaw_rate, Drive::begin_ns, 1.0);
  drive.wiring.add_sample(yaw_rate, drive.t_ns + hour_ns, 1.0);
  drive.go(20.0, none);
  EXPECT_EQ(drive.found(), "");
  Drive other;
  other.wiring.add_pose(estimator::CameraPose{.capture_ns = other.t_ns + hour_ns});
  other.go(30.0, factor({yaw_rate}, -1.0));
  EXPECT_EQ(other.found(), "yaw_rate sign") << "it does not wait for that time";
}

// A car that is driven violently, with correct sensors.

Course swinging(double speed, double turn, double omega) {
  return [=](double t) { return Motion{speed, 0.0, turn * std::sin(omega * t)}; };
}
Course pumping(double omega) {
  return [=](double t) {
    return Motion{1.5 + 3.5 / omega * std::sin(omega * t), 3.5 * std::cos(omega * t),
                  0.8 * std::sin(1.1 * t)};
  };
}
void as_it_is(Samples&, const Motion&) {}
void countersteered(Samples& samples, const Motion& motion) {
  samples[steering] = -0.12 * motion.turn;
}
void ploughing_on(Samples& samples, const Motion& motion) {
  samples[steering] = 1.05 * motion.turn;
}
// The inner wheel carries less load in a curve.
void inner_rear_spins(Samples& samples, const Motion& motion) {
  samples[motion.turn > 0.0 ? wheel_rear_left : wheel_rear_right] +=
      0.4 * std::clamp(std::abs(motion.turn) - 0.3, 0.0, 0.8);
}
void rear_axle_spins(Samples& samples, const Motion& motion) {
  const double bend = car.wheelbase() * motion.turn / motion.speed;
  factor({wheel_rear_left, wheel_rear_right}, 1.0 + 0.7 * bend * bend)(samples);
}

TEST(Wiring, DoesNotMistakeAggressiveDrivingForAFault) {
  struct Conduct {
    Course course;
    void (*car_does)(Samples&, const Motion&);
  };
  constexpr double hz = 2.0 * std::numbers::pi;
  const auto rear_axle_races = [](Samples& samples, const Motion&) {
    factor({wheel_rear_left, wheel_rear_right}, 2.5)(samples);
  };
  const Conduct cases[]{{swinging(1.5, 1.2, 1.2 * hz), as_it_is},
                        {swinging(1.5, 1.2, 1.5 * hz), as_it_is},
                        {swinging(1.5, 1.2, 2.3 * hz), as_it_is},
                        {pumping(1.2 * hz), as_it_is},
                        {pumping(1.5 * hz), as_it_is},
                        {steady(2.0, 1.8), countersteered},
                        {swinging(2.0, 1.8, 0.8), countersteered},
                        {swinging(3.0, 0.4, 0.8), ploughing_on},
                        {swinging(1.5, 1.5, 0.8), inner_rear_spins},
                        {swinging(0.8, 1.2, 0.8), inner_rear_spins},
                        {swinging(0.8, 1.2, 0.8), rear_axle_spins},
                        {weaving, rear_axle_races}};
  for (const Conduct& conduct : cases) {
    Drive drive;
    const Mistake mistake = [&](Samples& samples) {
      conduct.car_does(samples, conduct.course(drive.t()));
    };
    for (int k = 0; k < 9000; ++k) {
      if (k % 4 == 0) drive.see(1.0);
      drive.go(0.01, mistake, conduct.course);
      ASSERT_EQ(drive.found(), "") << "case " << &conduct - cases << " at " << drive.t() << " s";
    }
  }
}

TEST(Wiring, DoesNotAllocateWhileItSearches) {
  const Mistake mistakes = both(factor({steering}, -1.0), factor({accel_x, accel_y}, 1 / 9.81));
  std::vector<Samples> samples;
  for (int k = 0; k < 4000; ++k) mistakes(samples.emplace_back(sensed(weaving(1e-2 * k))));
  Drive drive;
  const auto before = allocation_count();
  for (const Samples& now : samples) {
    drive.t_ns += step_ns;
    for (const auto& [source, value] : now) drive.wiring.add_sample(source, drive.t_ns, value);
    drive.wiring.update(drive.t_ns);
  }
  EXPECT_EQ(allocation_count(), before);
  EXPECT_EQ(drive.found(), "accel_x unit, accel_y unit, steering sign") << "it searched";
}

}  // namespace
}  // namespace odomd::daemon::wiring_test
