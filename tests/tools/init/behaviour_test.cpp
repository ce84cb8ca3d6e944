// Signs, scales and biases of artificial drives with known answers.
#include <functional>

#include "tests/gtest.hpp"
#include "tools/init/proposal.hpp"

namespace odomd::tools::behaviour_test {
namespace {

using estimator::Source;

constexpr double wheelbase = 2.5, track = 1.5;

/// A car that weaves at a varying speed, after ten seconds at rest.
struct Motion {
  static double speed(double t) { return t < 10.0 ? 0.0 : 8.0 - 6.0 * std::cos(0.3 * (t - 10.0)); }
  static double angle(double t) { return 0.1 * std::sin(0.7 * t) + 0.03; }
  static double yaw_rate(double t) { return speed(t) * std::tan(angle(t)) / wheelbase; }
};

class Behaviour : public testing::Test {
 protected:
  /// Adds a signal, in SI units unless a unit is given.
  void add(Source role, const std::function<double(double)>& value,
           can::Unit unit = can::Unit::rad) {
    Choice choice;
    choice.candidate.role = role;
    choice.candidate.message = &message_;
    choice.candidate.signal = &signal_;
    choice.candidate.unit = unit;
    for (int k = 0; k < 4000; ++k) {
      const double t = 0.02 * k;
      if (std::isnan(value(t))) continue;
      choice.series.t_ns.push_back(std::llround(t * 1e9));
      choice.series.value.push_back(value(t));
    }
    proposal_.of(role) = std::move(choice);
  }
  void add_wheels() {
    add(Source::wheel_rear_left,
        [](double t) { return Motion::speed(t) - 0.5 * track * Motion::yaw_rate(t); });
    add(Source::wheel_rear_right,
        [](double t) { return Motion::speed(t) + 0.5 * track * Motion::yaw_rate(t); });
  }
  const Choice& checked(Source role) {
    check_behaviour(proposal_, {.wheelbase = wheelbase});
    return *proposal_.of(role);
  }

  can::Message message_;
  can::Signal signal_{.unit = "rad"};
  Proposal proposal_;
};

TEST_F(Behaviour, InvertsAGyroThatIsPositiveToTheRightAndFindsTheTrack) {
  add_wheels();
  add(Source::yaw_rate, [](double t) { return -Motion::yaw_rate(t); });
  EXPECT_EQ(checked(Source::yaw_rate).scale, -1.0);
  EXPECT_TRUE(proposal_.of(Source::yaw_rate)->sure());
  EXPECT_NEAR(proposal_.measured_track.value(), track, 0.02);
}

TEST_F(Behaviour, FindsTheRatioOfASteeringWheel) {
  add_wheels();
  add(Source::yaw_rate, Motion::yaw_rate);
  add(Source::steering, [](double t) { return -15.0 * Motion::angle(t); });
  EXPECT_NEAR(checked(Source::steering).scale, -1.0 / 15.0, 0.003);
  EXPECT_TRUE(proposal_.of(Source::steering)->sure());
}

TEST_F(Behaviour, KeepsTheAngleOfTheFrontWheelsAndAGyroThatIsPositiveToTheLeft) {
  add_wheels();
  add(Source::yaw_rate, Motion::yaw_rate);
  add(Source::steering, Motion::angle);
  EXPECT_EQ(checked(Source::steering).scale, 1.0);
  EXPECT_EQ(proposal_.of(Source::yaw_rate)->scale, 1.0);
  EXPECT_TRUE(proposal_.of(Source::steering)->sure());
}

TEST_F(Behaviour, FindsTheRatioAtOneSpeedAndTheLockOfACommand) {
  const auto slow = [](double) { return 4.0; };
  add(Source::wheel_rear, slow);
  add(Source::yaw_rate, [&](double t) { return slow(t) * std::tan(Motion::angle(t)) / wheelbase; });
  for (const double ratio : {15.0, 22.0, 1.0}) {
    SCOPED_TRACE(ratio);
    add(Source::steering, [&](double t) { return ratio * Motion::angle(t); });
    EXPECT_NEAR(checked(Source::steering).scale, 1.0 / ratio, 0.08 / ratio);
    EXPECT_TRUE(proposal_.of(Source::steering)->sure());
  }
  signal_.unit = "";
  add(
      Source::steering, [](double t) { return Motion::angle(t) / 0.4; }, can::Unit::none);
  EXPECT_NEAR(checked(Source::steering).scale, 0.4, 0.03);
  EXPECT_TRUE(proposal_.of(Source::steering)->scale_fits);
}

TEST_F(Behaviour, SetsASignByMajorityButIsUnsure) {
  add(Source::wheel_rear, Motion::speed);
  add(Source::yaw_rate, Motion::yaw_rate);
  add(Source::steering, Motion::angle);
  add(Source::accel_y, [](double t) { return -Motion::speed(t) * Motion::yaw_rate(t); });
  EXPECT_EQ(checked(Source::accel_y).scale, -1.0);
  EXPECT_FALSE(proposal_.of(Source::accel_y)->sure());
  EXPECT_EQ(proposal_.of(Source::yaw_rate)->scale, 1.0);
  EXPECT_THAT(proposal_.notes, Not(IsEmpty()));
}

TEST_F(Behaviour, IsUnsureIfTwoSensorsDisagree) {
  add(Source::wheel_rear, Motion::speed);
  add(Source::yaw_rate, [](double t) { return -Motion::yaw_rate(t); });
  add(Source::steering, Motion::angle);
  EXPECT_FALSE(checked(Source::yaw_rate).sure());
  EXPECT_FALSE(proposal_.of(Source::steering)->sure());
}

TEST_F(Behaviour, InvertsAnAccelerometerThatIsPositiveBackwards) {
  add_wheels();
  add(Source::accel_x, [](double t) { return t < 10.0 ? 0.0 : -1.8 * std::sin(0.3 * (t - 10.0)); });
  EXPECT_EQ(checked(Source::accel_x).scale, -1.0);
}

TEST_F(Behaviour, TakesABiasOnlyAtRestAndWarnsOfALargeOne) {
  struct Case {
    const char* what;
    double halt, bias, right_begins;  // [s], [rad/s], [s]
    bool creeps, has_offset, sure;
  };
  for (const Case& one : {Case{"stands", 10.0, 0.02, 0.0, false, true, true},
                          {"a brief halt", 1.2, 0.02, 0.0, false, false, true},
                          {"far off", 10.0, -0.11, 0.0, false, true, false},
                          {"creeps with wheels at 0", 10.0, 0.0, 0.0, true, false, true},
                          {"one wheel alone is at 0", 10.0, 0.02, 10.0, false, false, true}}) {
    SCOPED_TRACE(one.what);
    const auto speed = [&](double t) { return t < one.halt ? 0.0 : Motion::speed(t + 10.0); };
    proposal_ = {};
    for (const double y : {0.5 * track, -0.5 * track})
      add(y > 0.0 ? Source::wheel_rear_left : Source::wheel_rear_right, [&](double t) {
        const bool silent = y < 0.0 && t < one.right_begins;
        return silent ? NAN : speed(t) * (1.0 - y * Motion::angle(t) / wheelbase);
      });
    add(Source::yaw_rate, [&](double t) {
      const double outlier = std::fmod(t, 1.0) < 0.02 ? 2.0 : 0.0;
      const double creep = one.creeps && t < one.halt ? 0.1 * std::sin(2.0 * t) : 0.0;
      return speed(t) * Motion::angle(t) / wheelbase + one.bias + outlier + creep;
    });
    const Choice& gyro = checked(Source::yaw_rate);
    EXPECT_NEAR(gyro.offset, one.has_offset ? -one.bias : 0.0, 1e-3);
    EXPECT_EQ(gyro.sure(), one.sure);
  }
}

TEST_F(Behaviour, BlamesTheNumbersOfAMotorBeforeTheGyro) {
  add(
      Source::motor, [](double t) { return 60.0 * Motion::speed(t); }, can::Unit::rpm);
  add(Source::yaw_rate, Motion::yaw_rate);
  add(Source::accel_y, [](double t) { return Motion::speed(t) * Motion::yaw_rate(t); });
  check_behaviour(proposal_, {.wheelbase = wheelbase, .wheel_radius = 0.1, .gear_ratio = 1.0});
  EXPECT_EQ(proposal_.of(Source::motor)->warnings.size(), 1U);
  EXPECT_TRUE(proposal_.of(Source::yaw_rate)->warnings.size() <= 1U);
}

TEST_F(Behaviour, WarnsOfAYawRateInTheWrongUnitAndOfAWrongWheel) {
  add_wheels();
  add(Source::wheel_front_left, [](double t) { return 3.6 * Motion::speed(t); });
  add(Source::yaw_rate, [](double t) { return Motion::yaw_rate(t) / 57.3; });
  check_behaviour(proposal_, {.wheelbase = wheelbase, .track = track});
  EXPECT_FALSE(proposal_.of(Source::yaw_rate)->sure());
  EXPECT_FALSE(proposal_.of(Source::wheel_front_left)->sure());
}

TEST_F(Behaviour, IsUnsureOfALogAtRest) {
  add(Source::wheel_rear, [](double) { return 0.0; });
  add(Source::yaw_rate, [](double t) { return 0.001 * std::sin(90.0 * t); });
  EXPECT_FALSE(checked(Source::yaw_rate).sure());
  EXPECT_THAT(proposal_.notes, Not(IsEmpty()));
}

}  // namespace
}  // namespace odomd::tools::behaviour_test
