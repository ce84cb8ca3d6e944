// Integrity on a simulated drive: detects each fault, and lowers the flag after it.
#include "estimator/integrity/integrity.hpp"

#include <optional>

#include "simulated_drive.hpp"
#include "tests/allocation_count.hpp"
#include "tests/gtest.hpp"

namespace odomd::estimator::integrity_test {
namespace {

TEST(Integrity, DetectsAFrozenSource) {
  for (const Source source : {Source::yaw_rate, Source::accel_y, Source::steering,
                              Source::wheel_front_left, Source::wheel_rear_right}) {
    // The reading is held while the car turns to one side.
    Drive drive(slalom);
    drive.until(6.0);
    drive.until(10.5, frozen(source));
    EXPECT_EQ(drive.flag(source), SourceFlag::frozen) << source_names[index_of(source)];
    EXPECT_THAT(drive.flagged(), ElementsAre(source_names[index_of(source)]));
  }
}

TEST(Integrity, DetectsAContradictionWithinHalfASecond) {
  const auto times = [](double factor) {
    return failing(Source::wheel_rear_left,
                   [factor](double, double value) { return factor * value; });
  };
  const Equipment signed_wheels;
  const Equipment reversing{.unsigned_wheels = true, .camera = true};
  struct Case {
    Source source;
    Failure failure;
    Equipment equipment;
    bool wheel = false;
  };
  const Case cases[] = {
      {Source::yaw_rate, offset(Source::yaw_rate, 1.5), signed_wheels},
      {Source::accel_y, offset(Source::accel_y, 5.0), signed_wheels},
      {Source::accel_x, offset(Source::accel_x, -5.0), signed_wheels},
      {Source::wheel_rear_left, times(0.0), signed_wheels, true},
      {Source::wheel_rear_left, times(2.0), signed_wheels, true},
      {Source::yaw_rate, offset(Source::yaw_rate, 1.5), reversing},
      {Source::accel_y, offset(Source::accel_y, 5.0), reversing},
      {Source::wheel_rear_left, offset(Source::wheel_rear_left, 1.5), reversing, true},
  };
  for (const auto& [source, failure, equipment, wheel] : cases) {
    const double direction = equipment.unsigned_wheels ? -1.0 : 1.0;
    Drive drive(equipment.unsigned_wheels ? slalom_backwards : slalom, equipment);
    drive.until(7.3);
    drive.until(wheel && !equipment.unsigned_wheels ? 7.8 : 8.0, failure);
    EXPECT_NE(drive.flag(source), SourceFlag::ok) << source_names[index_of(source)];
    EXPECT_THAT(drive.flagged(), ElementsAre(source_names[index_of(source)]));
    if (wheel) continue;
    EXPECT_EQ(drive.flag(source), SourceFlag::drifting) << source_names[index_of(source)];
    EXPECT_LT(drive.raised_s(source).value_or(9.0), 7.8) << source_names[index_of(source)];
    // The consensus does not follow the faulty source.
    EXPECT_NEAR(drive.speed(), direction * slalom(8.0).speed, 0.1);
  }
}

TEST(Integrity, DistinguishesALockedAxleFromASpinningOneInBothDirections) {
  // The car brakes from 5 s to 6 s, with front wheels that lock, then accelerates, with rear wheels
  // that spin.
  struct Axle {
    bool front;
    double begin_s;
    double slip;  ///< of the measured speed to that of the car
  };
  for (const Equipment& equipment : {Equipment{}, Equipment{.unsigned_wheels = true}}) {
    for (const double direction : {1.0, -1.0}) {
      const auto motion = [direction](double t) {
        const double v = t < 5.0 ? 3.0 : t < 6.0 ? 3.0 - 2.0 * (t - 5.0) : 1.0 + 2.0 * (t - 6.0);
        return Motion{direction * v, 0.3 * std::sin(1.3 * t)};
      };
      for (const Axle& axle : {Axle{true, 5.3, 0.1}, Axle{false, 6.3, 3.0}}) {
        Drive drive(motion, equipment);
        drive.until(axle.begin_s);
        drive.until(axle.begin_s + 0.4, [&](Source source, double, double value) {
          const bool slips = is_single_wheel(source) && is_front(source) == axle.front;
          return std::optional(slips ? axle.slip * value : value);
        });
        for (const Source wheel : all_sources) {
          if (!is_single_wheel(wheel)) continue;
          EXPECT_EQ(drive.flag(wheel),
                    is_front(wheel) == axle.front ? SourceFlag::slipping : SourceFlag::ok)
              << source_names[index_of(wheel)] << ", slip " << axle.slip << ", " << direction
              << (equipment.unsigned_wheels ? ", unsigned" : ", signed");
        }
      }
    }
  }
}

TEST(Integrity, LowersAFlagWhenTheFaultIsGone) {
  Drive drive(slalom);
  drive.until(5.0);
  drive.until(6.0, offset(Source::yaw_rate, 1.5));
  EXPECT_EQ(drive.flag(Source::yaw_rate), SourceFlag::drifting);
  drive.until(6.5);
  EXPECT_EQ(drive.flag(Source::yaw_rate), SourceFlag::drifting);  // 0.5 s is not enough
  drive.until(8.0);
  EXPECT_EQ(drive.flag(Source::yaw_rate), SourceFlag::ok);
}

Failure inverted_gyro() {
  return failing(Source::yaw_rate, [](double, double value) { return -value; });
}

TEST(Integrity, AgreementOnAStraightSaysLittleAboutAGyro) {
  const auto bend_then_straight = [](double t) { return Motion{1.5, t < 5.0 ? 0.3 : 0.0}; };
  Drive drive(bend_then_straight);
  drive.until(4.0);
  drive.until(8.0, inverted_gyro());
  EXPECT_EQ(drive.flag(Source::yaw_rate), SourceFlag::drifting);
  drive.until(14.0);
  EXPECT_EQ(drive.flag(Source::yaw_rate), SourceFlag::ok);
}

TEST(Integrity, FlagsNeitherOfTwoThatContradictEachOther) {
  Drive drive(slalom);
  drive.until(5.0);
  const auto only_gyro_and_steering = [](Source source, double t,
                                         double value) -> std::optional<double> {
    if (source == Source::yaw_rate || source == Source::steering) return value;
    // One wheel of an axle alone does not measure a turn, either.
    return source == Source::wheel_rear_left ? std::optional(slalom(t).speed) : std::nullopt;
  };
  drive.until(8.0, only_gyro_and_steering);
  drive.until(9.0, [&](Source source, double t, double value) {
    return only_gyro_and_steering(source, t, source == Source::yaw_rate ? value + 2.5 : value);
  });
  EXPECT_TRUE(drive.integrity.trusted(Source::yaw_rate));
  EXPECT_TRUE(drive.integrity.trusted(Source::steering));
  EXPECT_TRUE(drive.integrity.agreed().contradicted);
  EXPECT_FALSE(drive.integrity.agrees(Source::yaw_rate));
}

TEST(Integrity, DetectsFrozenSourcesByTheCameraAlone) {
  for (const Source source : {Source::yaw_rate, Source::steering}) {
    Drive drive(slalom, {.camera = true, .alone = source});
    drive.until(4.0);
    EXPECT_THAT(drive.flagged(), IsEmpty());
    drive.until(6.5, frozen(source));
    EXPECT_EQ(drive.flag(source), SourceFlag::frozen) << source_names[index_of(source)];
    EXPECT_THAT(drive.flagged(), ElementsAre(source_names[index_of(source)]));
  }
}

TEST(Integrity, IfBothRepeatFlagsTheCameraThatSeesNoMotion) {
  // In a long bend, a coarse gyro and a steering within its range repeat without a fault.
  const auto bend = [](double t) { return Motion{1.5, t < 1.0 ? 0.17 : 0.14}; };
  const Failure coarse = failing(
      Source::yaw_rate, [](double, double value) { return 0.1 * std::round(10.0 * value); });
  for (const Source source : {Source::yaw_rate, Source::steering}) {
    Drive drive(bend, {.camera = true, .alone = source});
    drive.until(4.0, coarse);
    drive.freeze_camera();
    drive.until(8.0, coarse);
    EXPECT_EQ(drive.flag(source), SourceFlag::ok) << source_names[index_of(source)];
    EXPECT_EQ(drive.flag(Source::camera), SourceFlag::frozen) << source_names[index_of(source)];
  }
}

TEST(Integrity, DetectsAFrozenCamera) {
  Drive drive(slalom, {.camera = true});
  drive.until(8.0);
  drive.freeze_camera();
  drive.until(9.5);
  EXPECT_EQ(drive.flag(Source::camera), SourceFlag::frozen);
  EXPECT_THAT(drive.flagged(), ElementsAre("camera"));
}

TEST(Integrity, IgnoresASampleOlderThanTheNewest) {
  Drive drive(slalom);
  drive.until(5.0);
  Integrity late = drive.integrity;
  late.add(Source::yaw_rate, start_ns + 4'000 * ms, 9.0, 0.005);
  // Check while the gyro is still alive.
  late.check({}, start_ns + 5'015 * ms);
  drive.integrity.check({}, start_ns + 5'015 * ms);
  EXPECT_NE(drive.integrity.motion().motion[integrity::of::yaw_rate],
            drive.integrity.agreed().without_gyro.motion[integrity::of::yaw_rate]);
  EXPECT_EQ(late.motion().motion[integrity::of::yaw_rate],
            drive.integrity.motion().motion[integrity::of::yaw_rate]);
}

TEST(Integrity, AQuantisedWheelIsTrustedAgain) {
  Drive drive(slalom);
  double held = 0.0;
  const auto freezes = [&held](Source source, double t, double value) -> std::optional<double> {
    if (source != Source::wheel_rear_left) return value;
    const bool frozen = t > 10.0 && t < 12.0;
    held = frozen ? held : 0.03 * std::round(value / 0.03);
    return held;
  };
  drive.until(12.0, freezes);
  ASSERT_FALSE(drive.integrity.trusted(Source::wheel_rear_left));
  drive.until(16.0, freezes);
  EXPECT_TRUE(drive.integrity.trusted(Source::wheel_rear_left));
}

TEST(Integrity, DetectsAFrozenGyroByTheCameraAlone) {
  const auto straight_first = [](double t) {
    return Motion{1.5, t < 12.0 ? 0.0 : 0.3 * std::sin(1.3 * (t - 12.0))};
  };
  Drive drive(straight_first, {.camera = true});
  double held = 0.0;
  drive.until(14.0, [&held](Source source, double t, double value) -> std::optional<double> {
    if (is_wheel(source)) return std::nullopt;
    if (source != Source::yaw_rate) return value;
    return t > 10.0 ? held : held = value;
  });
  EXPECT_EQ(drive.flag(Source::yaw_rate), SourceFlag::frozen);
}

TEST(Integrity, ASilentSourceRegainsNoTrust) {
  Drive drive(slalom);
  drive.until(5.0);
  drive.until(7.0, offset(Source::yaw_rate, 1.0));
  drive.until(15.0, [](Source source, double, double value) {
    return source == Source::yaw_rate ? std::nullopt : std::optional(value);
  });
  EXPECT_FALSE(drive.integrity.trusted(Source::yaw_rate));
}

TEST(Integrity, DoesNotAllocate) {
  // Unsigned wheels and a failing gyro exercise all of the checks.
  Drive drive(slalom, {.unsigned_wheels = true});
  drive.until(2.0);
  const Failure fails = offset(Source::yaw_rate, 1.0);
  const auto before = allocation_count();
  drive.until(4.0, fails);
  EXPECT_EQ(allocation_count(), before);
  EXPECT_FALSE(drive.integrity.trusted(Source::yaw_rate));
}

// A wheel that spins up faster than any car and recovers, and a wheel that follows a braking car.
TEST(Integrity, AddsUpTheSlipOfAWheel) {
  const auto ramp = [](double t, double rate) { return rate * std::clamp(t - 1.0, 0.0, 0.3); };
  for (const auto& [rate, slips] : {std::pair{60.0, true}, {-60.0, true}, {9.0, false}}) {
    Integrity integrity;
    double spun = 0.0;
    for (std::int64_t k = 0; k < 300; ++k) {
      const double t = 0.01 * static_cast<double>(k);
      const double speed = 20.0 + ramp(t, rate) - ramp(t - 1.0, rate);
      integrity.add(Source::motor, 1'000 * ms + 10 * k * ms, speed, 0.1);
      spun = k == 180 ? integrity.history(Source::motor).slip : spun;
    }
    EXPECT_NEAR(spun, slips ? std::copysign(0.3 * (60.0 - 1.5 * gravity), rate) : 0.0, 10.0)
        << rate;
    EXPECT_NEAR(integrity.history(Source::motor).slip, 0.0, slips ? 0.5 : 1e-9) << rate;
    EXPECT_EQ(integrity.slip_sigma(Source::motor), 0.0) << "no camera has seen it";
  }
}

TEST(Integrity, AGyroOfTheWrongSignIsNotReversing) {
  const auto from_rest = [](double t) {
    return Motion{1.5 * std::clamp(t - 2.0, 0.0, 1.0), t < 4.0 ? 0.0 : 0.3 * std::sin(1.3 * t)};
  };
  Drive drive(from_rest, {.unsigned_wheels = true});
  drive.until(12.0, inverted_gyro());
  EXPECT_FALSE(drive.integrity.backwards());
  EXPECT_NEAR(drive.speed(), 1.5, 0.1);
  EXPECT_THAT(drive.flagged(), ElementsAre("yaw_rate"));
}

}  // namespace
}  // namespace odomd::estimator::integrity_test
