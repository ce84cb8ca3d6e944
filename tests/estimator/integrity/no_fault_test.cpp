// Integrity raises no flag on fault-free simulated drives, however unusual.
#include <map>
#include <optional>

#include "simulated_drive.hpp"
#include "tests/gtest.hpp"

namespace odomd::estimator::integrity_test {
namespace {

TEST(Integrity, RaisesNoFlagInASlalom) {
  for (const bool camera : {false, true}) {
    Drive drive(slalom, {.camera = camera});
    drive.until(60.0);
    EXPECT_THAT(drive.flagged(), IsEmpty());
    EXPECT_FALSE(drive.integrity.agreed().contradicted);
    EXPECT_NEAR(drive.speed(), slalom(59.97).speed, 0.03);
    EXPECT_LT(drive.integrity.motion().sigma[integrity::of::speed], 0.1);
  }
}

TEST(Integrity, RestSteadyDrivingAndHeldSteeringAreNotFaults) {
  using MotionAt = Motion (*)(double t);
  for (const auto& [name, motion] : {
           std::pair<const char*, MotionAt>{
               "sets off at 1.5 m/s² after a rest",
               [](double t) {
                 const Motion going = slalom(t);
                 return t < 5.0 ? Motion{0.0, 0.2}
                                : Motion{std::min(going.speed, 1.5 * (t - 5.0)), going.steering};
               }},
           {"wheels and steering repeat throughout",
            [](double) {
              return Motion{1.5, 0.1};
            }},
           {"the command rests at full lock on either side",
            [](double t) {
              return Motion{1.0, std::clamp(0.6 * std::sin(0.8 * t), -0.3, 0.3)};
            }},
       }) {
    Drive drive(motion);
    drive.until(30.0);
    EXPECT_THAT(drive.flagged(), IsEmpty()) << name;
  }
}

TEST(Integrity, UnsignedWheelsInReverseAreNotFaults) {
  // Backwards through a slalom, repeatedly braking hard and releasing the brake.
  const auto backwards = [](double t) {
    const Motion ahead = slalom(t);
    return Motion{-ahead.speed - 0.8 * std::sin(4.0 * t), ahead.steering};
  };
  const auto nothing_of = [&](const Equipment& equipment, const char* what) {
    Drive drive(backwards, equipment);
    drive.until(30.0);
    EXPECT_THAT(drive.flagged(), IsEmpty()) << what;
    return drive.integrity.backwards();
  };
  EXPECT_TRUE(nothing_of({.unsigned_wheels = true}, "alone"));
  EXPECT_TRUE(nothing_of({.unsigned_wheels = true, .camera = true}, "with camera"));
  EXPECT_FALSE(
      nothing_of({.unsigned_wheels = true, .camera = true, .direction = -1.0}, "measured"));
  EXPECT_TRUE(nothing_of({.unsigned_wheels = true, .camera = true, .direction = 0.0}, "unknown"));
}

TEST(Integrity, FindsTheSignOfUnsignedWheelsAfterEachHalt) {
  // The car drives forward, rests, reverses and rests again, for three seconds each.
  const auto to_and_fro = [](double t) {
    const int part = static_cast<int>(t / 3.0) % 4;
    const double ramp = std::min({1.0, std::fmod(t, 3.0), 3.0 - std::fmod(t, 3.0)});
    const double speed = part == 0 ? 1.5 * ramp : part == 2 ? -1.5 * ramp : 0.0;
    return Motion{speed, 0.3 * std::sin(2.0 * t)};
  };
  Drive drive(to_and_fro, {.unsigned_wheels = true});
  for (int round = 0; round < 3; ++round) {
    drive.until(12.0 * round + 2.0);
    EXPECT_FALSE(drive.integrity.backwards()) << round;
    EXPECT_GT(drive.speed(), 1.0) << round;
    drive.until(12.0 * round + 8.0);
    EXPECT_TRUE(drive.integrity.backwards()) << round;
    EXPECT_LT(drive.speed(), -1.0) << round;
    drive.until(12.0 * round + 12.0);
  }
  EXPECT_THAT(drive.flagged(), IsEmpty());
}

/// A car whose rear slides out in a corner until it spins: β grows to a right angle and beyond,
/// while the driver countersteers.
TEST(Integrity, ASpinIsNotAFaultOfTheSteering) {
  constexpr double spin_s = 3.0;
  const double l = Vehicle{}.wheelbase();
  const double into = std::atan(l * 3.0 / 2.4);  // δ [rad]
  const double against = -0.25;
  const auto corner = [into](double t) { return Motion{2.4, into * std::clamp(t, 0.0, 1.0)}; };
  const auto speed = [](double s) { return std::max(2.4 - 4.0 * s, 0.0); };
  const auto slip = [](double s) { return 2.4 * s; };  // β [rad]
  const auto v_x = [&](double s) { return speed(s) * std::cos(slip(s)); };
  const auto v_y = [&](double s) { return -speed(s) * std::sin(slip(s)); };
  const Failure spin = [&](Source source, double t, double value) -> std::optional<double> {
    const double s = t - spin_s;
    if (s < 0.0) return value;
    constexpr double h = 1e-3;
    const double turn = 3.0 + 2.0 * std::min(s, 0.3);
    const double half_track = 0.5 * Vehicle{}.track_width;
    const double steering = std::lerp(into, against, std::min(s / 0.2, 1.0));
    const auto wheel = [&](double left, double ahead, double delta) {
      return (v_x(s) - left * turn) * std::cos(delta) + (v_y(s) + ahead * turn) * std::sin(delta);
    };
    const std::map<Source, double> spinning{
        {Source::yaw_rate, turn + 0.01 * std::sin(97.0 * t)},
        {Source::accel_x, (v_x(s + h) - v_x(s - h)) / (2.0 * h) - turn * v_y(s)},
        {Source::accel_y, (v_y(s + h) - v_y(s - h)) / (2.0 * h) + turn * v_x(s)},
        {Source::wheel_front_left, wheel(half_track, l, steering)},
        {Source::wheel_front_right, wheel(-half_track, l, steering)},
        {Source::wheel_rear_left, wheel(half_track, 0.0, 0.0)},
        {Source::wheel_rear_right, wheel(-half_track, 0.0, 0.0)},
        {Source::steering, steering}};
    return spinning.at(source);
  };
  Drive drive(corner);
  drive.until(spin_s + 0.6, spin);
  EXPECT_FALSE(drive.raised_s(Source::steering));
  EXPECT_FALSE(drive.raised_s(Source::yaw_rate));
}

TEST(Integrity, ForgivesASingleValue) {
  const std::pair<Source, double> spikes[] = {
      {Source::yaw_rate, 8.0}, {Source::yaw_rate, 20.0},        {Source::accel_x, 50.0},
      {Source::accel_y, 50.0}, {Source::wheel_rear_left, 30.0}, {Source::steering, 1.0}};
  for (const auto& [source, value] : spikes) {
    Drive drive(slalom);
    drive.until(3.0);
    drive.until(3.01, failing(source, [value = value](double, double) { return value; }));
    drive.until(5.0);
    EXPECT_THAT(drive.flagged(), IsEmpty()) << source_names[index_of(source)] << ' ' << value;
  }
}

TEST(Integrity, ACameraWithOutliersIsNotFaulty) {
  for (const double speed : {0.2, 1.0, 3.0}) {
    const auto circle = [speed](double t) { return Motion{std::min(speed, t), 0.1}; };
    Drive drive(circle, {.camera = true, .outliers = 0.2});
    drive.until(60.0);
    EXPECT_THAT(drive.flagged(), IsEmpty()) << speed;
  }
}

TEST(Integrity, AChangeDuringAGapIsAcceptedAfterwards) {
  // The car brakes from 30 m/s to 6 m/s while the bus is silent.
  const auto braking = [](double t) {
    return Motion{30.0 - 8.0 * std::clamp(t - 4.0, 0.0, 3.0) + 0.3 * std::sin(2.0 * t)};
  };
  Drive drive(braking);
  drive.until(10.0, [](Source, double t, double value) {
    return t < 4.0 || t > 7.0 ? std::optional(value) : std::nullopt;
  });
  EXPECT_NEAR(drive.speed(), 6.0, 0.5);
  EXPECT_LT(drive.integrity.motion().sigma[integrity::of::speed], 0.1);
  for (const Source source : all_sources)
    EXPECT_TRUE(drive.integrity.trusted(source)) << source_names[index_of(source)];
}

}  // namespace
}  // namespace odomd::estimator::integrity_test
