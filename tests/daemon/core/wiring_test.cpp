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
using Found = std::map<std::string, std::string>;

constexpr estimator::Vehicle car{};
constexpr std::int64_t step_ns = 10'000'000;

struct Motion {
  double speed = 0.0, acceleration = 0.0, turn = 0.0;
};

Motion weaving(double t) {
  return {1.5 + 0.9 * std::sin(0.8 * t), 0.72 * std::cos(0.8 * t), 1.2 * std::sin(1.1 * t)};
}
Motion standing(double) {
  return {};
}
Motion backwards(double t) {
  const Motion ahead = weaving(t);
  return {-0.4 * ahead.speed, -0.4 * ahead.acceleration, ahead.turn};
}
Motion straight_on(double) {
  return {1.5, 0.0, 0.0};
}

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
Mistake factor(std::initializer_list<Source> sources, double by) {
  return [sources = std::vector<Source>(sources), by](Samples& samples) {
    for (const Source source : sources) samples[source] *= by;
  };
}
Mistake swapped(Source a, Source b) {
  return [a, b](Samples& samples) { std::swap(samples[a], samples[b]); };
}
Mistake without(std::initializer_list<Source> sources) {
  return [sources = std::vector<Source>(sources)](Samples& samples) {
    for (const Source source : sources) samples.erase(source);
  };
}
Mistake both(const Mistake& a, const Mistake& b) {
  return [a, b](Samples& samples) {
    a(samples);
    b(samples);
  };
}

class WiringTest : public ::testing::Test {
 protected:
  void drive(double seconds, const Mistake& mistake, Motion (*motion)(double) = weaving) {
    for (int k = 0; k < static_cast<int>(100.0 * seconds); ++k) {
      t_ns_ += step_ns;
      Samples samples = sensed(motion(1e-9 * static_cast<double>(t_ns_ - begin_ns)));
      mistake(samples);
      for (const auto& [source, value] : samples) wiring_.hear(source, t_ns_, value);
      wiring_.look(t_ns_);
    }
  }
  [[nodiscard]] Found found() const {
    Found found;
    for (std::size_t source = 0; source < estimator::source_count; ++source)
      if (const WiringFault fault = wiring_.fault(source); fault != WiringFault::none)
        found[std::string{estimator::source_names[source]}] =
            wiring_names[static_cast<std::size_t>(fault)];
    return found;
  }
  static constexpr std::int64_t begin_ns = 1'760'000'000'000'000'000;
  std::int64_t t_ns_ = begin_ns;
  Wiring wiring_{car};
};

TEST_F(WiringTest, FindsNothingWrongWithASoundCar) {
  for (const auto motion : {weaving, standing, backwards, straight_on, weaving}) {
    drive(40.0, none, motion);
    EXPECT_THAT(found(), IsEmpty());
  }
}

struct MistakeCase {
  const char* name;
  Mistake mistake;
  Found found;
  double seconds = 25.0;  ///< time limit
};
class WiringMistake : public WiringTest, public ::testing::WithParamInterface<MistakeCase> {};

TEST_P(WiringMistake, IsNamedHeldAndForgottenWhenItIsGone) {
  drive(3.0, GetParam().mistake);
  EXPECT_THAT(found(), IsEmpty()) << "too early";
  drive(GetParam().seconds, GetParam().mistake);
  EXPECT_EQ(found(), GetParam().found);
  drive(60.0, GetParam().mistake, standing);
  drive(60.0, GetParam().mistake, straight_on);
  EXPECT_EQ(found(), GetParam().found) << "held where nothing shows";
  drive(60.0, GetParam().mistake);
  EXPECT_EQ(found(), GetParam().found);
  drive(150.0, none);
  EXPECT_THAT(found(), IsEmpty());
}

const Found wheels_swapped{{"wheel_front_left", "left_right_swapped"},
                           {"wheel_front_right", "left_right_swapped"},
                           {"wheel_rear_left", "left_right_swapped"},
                           {"wheel_rear_right", "left_right_swapped"}};
Found of_wheels(const std::string& what) {
  Found found = wheels_swapped;
  for (auto& [wheel, fault] : found) fault = what;
  return found;
}

INSTANTIATE_TEST_SUITE_P(
    Of, WiringMistake,
    ::testing::Values(
        MistakeCase{"gyro_sign", factor({yaw_rate}, -1.0), {{"yaw_rate", "sign"}}},
        MistakeCase{"gyro_in_degrees", factor({yaw_rate}, 57.3), {{"yaw_rate", "unit"}}},
        MistakeCase{"gyro_taken_for_degrees", factor({yaw_rate}, 1 / 57.3), {{"yaw_rate", "unit"}}},
        MistakeCase{"steering_sign", factor({steering}, -1.0), {{"steering", "sign"}}, 50.0},
        MistakeCase{"steering_in_degrees", factor({steering}, 57.3), {{"steering", "unit"}}, 50.0},
        MistakeCase{"front_wheels_swapped",
                    swapped(wheel_front_left, wheel_front_right),
                    {{"wheel_front_left", "left_right_swapped"},
                     {"wheel_front_right", "left_right_swapped"}}},
        MistakeCase{"rear_wheels_swapped",
                    swapped(wheel_rear_left, wheel_rear_right),
                    {{"wheel_rear_left", "left_right_swapped"},
                     {"wheel_rear_right", "left_right_swapped"}}},
        MistakeCase{"sides_swapped",
                    both(swapped(wheel_rear_left, wheel_rear_right),
                         swapped(wheel_front_left, wheel_front_right)),
                    wheels_swapped},
        MistakeCase{"axles_swapped",
                    both(swapped(wheel_rear_left, wheel_front_left),
                         swapped(wheel_rear_right, wheel_front_right)),
                    of_wheels("front_rear_swapped")},
        MistakeCase{"one_wheel_backwards",
                    factor({wheel_front_right}, -1.0),
                    {{"wheel_front_right", "sign"}}},
        MistakeCase{
            "wheels_in_km_per_h",
            factor({wheel_front_left, wheel_front_right, wheel_rear_left, wheel_rear_right}, 3.6),
            of_wheels("unit")},
        MistakeCase{
            "all_wheels_backwards",
            factor({wheel_front_left, wheel_front_right, wheel_rear_left, wheel_rear_right}, -1.0),
            of_wheels("sign")},
        MistakeCase{"accel_x_sign", factor({accel_x}, -1.0), {{"accel_x", "sign"}}},
        MistakeCase{"accel_y_sign", factor({accel_y}, -1.0), {{"accel_y", "sign"}}},
        MistakeCase{"accel_in_g",
                    factor({accel_x, accel_y}, 1 / 9.81),
                    {{"accel_x", "unit"}, {"accel_y", "unit"}}},
        MistakeCase{"accel_axes_swapped",
                    swapped(accel_x, accel_y),
                    {{"accel_x", "axes_swapped"}, {"accel_y", "axes_swapped"}}},
        MistakeCase{"accel_x_in_g", factor({accel_x}, 1 / 9.81), {{"accel_x", "unit"}}},
        MistakeCase{"accel_y_in_g", factor({accel_y}, 1 / 9.81), {{"accel_y", "unit"}}},
        MistakeCase{"left_wheels_backwards",
                    factor({wheel_front_left, wheel_rear_left}, -1.0),
                    {{"wheel_front_left", "sign"}, {"wheel_rear_left", "sign"}}},
        MistakeCase{"right_wheels_backwards",
                    factor({wheel_front_right, wheel_rear_right}, -1.0),
                    {{"wheel_front_right", "sign"}, {"wheel_rear_right", "sign"}}},
        MistakeCase{
            "gear_ratio_forgotten", factor({wheel_rear_left}, 7.5), {{"wheel_rear_left", "unit"}}},
        MistakeCase{
            "diameter_for_radius", factor({wheel_rear_left}, 2.0), {{"wheel_rear_left", "unit"}}},
        MistakeCase{"two_at_once",
                    both(factor({steering}, -1.0), factor({accel_x, accel_y}, 1 / 9.81)),
                    {{"accel_x", "unit"}, {"accel_y", "unit"}, {"steering", "sign"}},
                    50.0}),
    [](const auto& test) { return test.param.name; });

TEST_F(WiringTest, NamesBothWhenTheyCannotBeDistinguished) {
  const Mistake few =
      without({accel_x, accel_y, wheel_front_left, wheel_front_right, wheel_rear_left});
  drive(40.0, both(few, factor({yaw_rate}, -1.0)));
  EXPECT_THAT(found(), UnorderedElementsAre(Pair("steering", "sign"), Pair("yaw_rate", "sign")));
}

TEST_F(WiringTest, LeavesAFaultOfAFewSecondsAlone) {
  drive(30.0, none);
  drive(3.0, factor({yaw_rate}, -1.0));
  EXPECT_THAT(found(), IsEmpty());
  drive(30.0, none);
  EXPECT_THAT(found(), IsEmpty());
}

// Unsigned wheels in reverse look like a gyro with the wrong sign.
TEST_F(WiringTest, DoesNotMistakeReversingForAWrongSignWhereWheelsKnowNone) {
  const Mistake unsigned_wheels = [](Samples& samples) {
    for (auto& [source, value] : samples)
      if (estimator::is_wheel(source)) value = std::abs(value);
  };
  drive(40.0, unsigned_wheels, backwards);
  EXPECT_THAT(found(), IsEmpty());
  const Mistake reversed = [&](Samples& samples) {
    unsigned_wheels(samples);
    samples[direction] = -1.0;
    samples[yaw_rate] *= -1.0;
  };
  drive(60.0, reversed, backwards);
  EXPECT_THAT(found(), ElementsAre(Pair("yaw_rate", "sign"))) << "with the gear it shows";
}

TEST_F(WiringTest, ComparesTheCamera) {
  double x = 0.0, y = 0.0, yaw = 0.0;
  for (int k = 0; k < 4000; ++k) {
    const Motion motion = weaving(1e-2 * k);
    yaw += 1e-2 * motion.turn;
    x += 1e-2 * motion.speed * std::cos(yaw);
    y += 1e-2 * motion.speed * std::sin(yaw);
    if (k % 4 == 0)
      wiring_.hear(estimator::CameraPose{.capture_ns = t_ns_, .x = x, .y = -y, .yaw = -yaw});
    drive(0.01, none);
  }
  EXPECT_THAT(found(), ElementsAre(Pair("camera", "sign")));
}

TEST_F(WiringTest, TakesTimeThatJumpsAndSamplesThatAreNoneWithoutHarm) {
  const Mistake broken = [](Samples& samples) { samples[yaw_rate] = std::nan(""); };
  drive(20.0, broken);
  t_ns_ += 3'600'000'000'000;
  drive(20.0, none);
  wiring_.hear(yaw_rate, begin_ns, 1.0);
  wiring_.hear(yaw_rate, t_ns_ + 3'600'000'000'000, 1.0);
  drive(20.0, none);
  EXPECT_THAT(found(), IsEmpty());
}

TEST_F(WiringTest, DoesNotWaitForAFirstSampleFromTheFuture) {
  wiring_.hear(estimator::CameraPose{.capture_ns = t_ns_ + 3'600'000'000'000});
  drive(30.0, factor({yaw_rate}, -1.0));
  EXPECT_THAT(found(), ElementsAre(Pair("yaw_rate", "sign")));
}

// A car that is driven violently, with correct sensors.
struct Conduct {
  const char* name;
  Motion (*motion)(double t);
  void (*car_does)(Samples&, const Motion&);
};
void as_it_is(Samples&, const Motion&) {}
class WildDriving : public WiringTest, public ::testing::WithParamInterface<Conduct> {};

TEST_P(WildDriving, IsNoMistakeInTheWiring) {
  double x = 0.0, y = 0.0, yaw = 0.0;
  for (int k = 0; k < 9000; ++k) {
    const Motion motion = GetParam().motion(1e-2 * k);
    yaw += 1e-2 * motion.turn;
    x += 1e-2 * motion.speed * std::cos(yaw);
    y += 1e-2 * motion.speed * std::sin(yaw);
    if (k % 4 == 0)
      wiring_.hear(estimator::CameraPose{.capture_ns = t_ns_, .x = x, .y = y, .yaw = yaw});
    drive(
        0.01, [&](Samples& samples) { GetParam().car_does(samples, motion); }, GetParam().motion);
    ASSERT_THAT(found(), IsEmpty()) << 1e-2 * k << " s";
  }
}

// Oscillates at a speed, without turning on average.
template <int tenths_of_hz>
Motion weaving_at(double t) {
  return {1.5, 0.0, 1.2 * std::sin(0.2 * std::numbers::pi * tenths_of_hz * t)};
}
template <int tenths_of_hz>
Motion pumping_at(double t) {
  const double omega = 0.2 * std::numbers::pi * tenths_of_hz;
  return {1.5 + 3.5 / omega * std::sin(omega * t), 3.5 * std::cos(omega * t),
          0.8 * std::sin(1.1 * t)};
}
Motion held_drift(double) {
  return {2.0, 0.0, 1.8};
}
Motion drift_to_and_fro(double t) {
  return {2.0, 0.0, 1.8 * std::sin(0.8 * t)};
}
void countersteered(Samples& samples, const Motion& motion) {
  samples[steering] = -0.12 * motion.turn;
}
Motion on_ice(double t) {
  return {3.0, 0.0, 0.4 * std::sin(0.8 * t)};
}
void ploughing_on(Samples& samples, const Motion& motion) {
  samples[steering] = 1.05 * motion.turn;
}
Motion wide_curves(double t) {
  return {1.5, 0.0, 1.5 * std::sin(0.8 * t)};
}
Motion gentle_curves(double t) {
  return {0.8, 0.0, 1.2 * std::sin(0.8 * t)};
}
// The inner wheel carries less load in a curve.
void inner_rear_spins(Samples& samples, const Motion& motion) {
  samples[motion.turn > 0.0 ? wheel_rear_left : wheel_rear_right] +=
      0.4 * std::clamp(std::abs(motion.turn) - 0.3, 0.0, 0.8);
}
void rear_axle_spins(Samples& samples, const Motion& motion) {
  const double bend = car.wheelbase() * motion.turn / motion.speed;
  for (const Source wheel : {wheel_rear_left, wheel_rear_right})
    samples[wheel] *= 1.0 + 0.7 * bend * bend;
}

INSTANTIATE_TEST_SUITE_P(
    Of, WildDriving,
    ::testing::Values(Conduct{"weaving_at_1_2_hz", weaving_at<12>, as_it_is},
                      Conduct{"weaving_at_1_5_hz", weaving_at<15>, as_it_is},
                      Conduct{"weaving_at_2_3_hz", weaving_at<23>, as_it_is},
                      Conduct{"pumping_at_1_2_hz", pumping_at<12>, as_it_is},
                      Conduct{"pumping_at_1_5_hz", pumping_at<15>, as_it_is},
                      Conduct{"held_drift", held_drift, countersteered},
                      Conduct{"drift_to_and_fro", drift_to_and_fro, countersteered},
                      Conduct{"ploughing", on_ice, ploughing_on},
                      Conduct{"inner_wheel_spinning", wide_curves, inner_rear_spins},
                      Conduct{"inner_wheel_spinning_gently", gentle_curves, inner_rear_spins},
                      Conduct{"rear_axle_spinning", gentle_curves, rear_axle_spins}),
    [](const auto& test) { return test.param.name; });

// The car drives forwards and backwards between standstills, and only the motor speed is signed.
TEST_F(WiringTest, TakesTheWayOfUnsignedWheelsFromASignedMotor) {
  const Mistake unsigned_wheels = [](Samples& samples) {
    samples[motor] = 0.5 * (samples[wheel_rear_left] + samples[wheel_rear_right]);
    for (const Source wheel :
         {wheel_front_left, wheel_front_right, wheel_rear_left, wheel_rear_right})
      samples[wheel] = std::abs(samples[wheel]);
  };
  for (const auto motion : {weaving, backwards, weaving, backwards}) {
    drive(40.0, unsigned_wheels, motion);
    EXPECT_THAT(found(), IsEmpty());
  }
}

TEST_F(WiringTest, FindsOtherFaultsNextToAMotorWithoutItsGearRatio) {
  const Mistake geared = [](Samples& samples) {
    samples[motor] = 7.5 * 0.5 * (samples[wheel_rear_left] + samples[wheel_rear_right]);
  };
  drive(40.0, both(geared, factor({yaw_rate}, -1.0)));
  EXPECT_THAT(found(), UnorderedElementsAre(Pair("motor", "unit"), Pair("yaw_rate", "sign")));
}

TEST_F(WiringTest, NamesAnInvertedDirectionInAdditionToTheWheels) {
  const Mistake inverted = [](Samples& samples) { samples[direction] = -1.0; };
  drive(40.0, inverted);
  EXPECT_THAT(found(), Contains(Pair("direction", "sign")));
}

TEST_F(WiringTest, DoesNotAllocateWhileItSearches) {
  const Mistake mistakes = both(factor({steering}, -1.0), factor({accel_x, accel_y}, 1 / 9.81));
  std::vector<Samples> samples;
  for (int k = 0; k < 4000; ++k) {
    samples.push_back(sensed(weaving(1e-2 * k)));
    mistakes(samples.back());
  }
  const auto before = allocation_count();
  for (const Samples& now : samples) {
    t_ns_ += step_ns;
    for (const auto& [source, value] : now) wiring_.hear(source, t_ns_, value);
    wiring_.look(t_ns_);
  }
  EXPECT_EQ(allocation_count(), before);
  EXPECT_EQ(found().size(), 3U) << "it searched";
}

}  // namespace
}  // namespace odomd::daemon::wiring_test
