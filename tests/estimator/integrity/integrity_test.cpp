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
    std::optional<double> held;
    drive.until(10.5, failing(source, [&](double, double value) {
                  held = held.value_or(value);
                  return *held;
                }));
    EXPECT_EQ(drive.integrity.flag(source), SourceFlag::frozen) << source_names[index_of(source)];
    EXPECT_EQ(drive.flagged(), 1) << source_names[index_of(source)];
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
    SCOPED_TRACE(source_names[index_of(source)]);
    const double direction = equipment.unsigned_wheels ? -1.0 : 1.0;
    Drive drive(equipment.unsigned_wheels ? slalom_backwards : slalom, equipment);
    drive.until(7.3);
    drive.until(wheel && !equipment.unsigned_wheels ? 7.8 : 8.0, failure);
    EXPECT_NE(drive.integrity.flag(source), SourceFlag::ok);
    EXPECT_EQ(drive.flagged(), 1);
    if (wheel) continue;
    EXPECT_EQ(drive.integrity.flag(source), SourceFlag::drifting);
    EXPECT_LT(drive.raised_s(source).value_or(9.0), 7.8);
    // The consensus does not follow the faulty source.
    EXPECT_NEAR(drive.integrity.motion().motion[integrity::of::speed],
                direction * slalom(8.0).speed, 0.1);
  }
}

TEST(Integrity, DistinguishesALockedAxleFromASpinningOneInBothDirections) {
  for (const bool unsigned_wheels : {false, true}) {
    for (const double direction : {1.0, -1.0}) {
      // The car brakes from 5 s to 6 s with locked front wheels, then accelerates with spinning
      // rear wheels.
      const auto motion = [direction](double t) {
        const double v = t < 5.0 ? 3.0 : t < 6.0 ? 3.0 - 2.0 * (t - 5.0) : 1.0 + 2.0 * (t - 6.0);
        return Motion{direction * v, 0.3 * std::sin(1.3 * t)};
      };
      const Equipment equipment{.unsigned_wheels = unsigned_wheels};
      const auto front = [](Source source) {
        return source == Source::wheel_front_left || source == Source::wheel_front_right;
      };
      const auto rear = [](Source source) {
        return source == Source::wheel_rear_left || source == Source::wheel_rear_right;
      };
      const auto what = [&] {
        return (unsigned_wheels ? "unsigned, " : "signed, ") + std::to_string(direction);
      };
      Drive locked(motion, equipment);
      locked.until(5.3);
      locked.until(5.7, [&](Source source, double, double value) -> std::optional<double> {
        return front(source) ? 0.1 * value : value;
      });
      EXPECT_EQ(locked.integrity.flag(Source::wheel_front_left), SourceFlag::slipping) << what();
      EXPECT_EQ(locked.integrity.flag(Source::wheel_front_right), SourceFlag::slipping) << what();
      EXPECT_EQ(locked.integrity.flag(Source::wheel_rear_left), SourceFlag::ok) << what();

      Drive spinning(motion, equipment);
      spinning.until(6.3);
      spinning.until(6.7, [&](Source source, double, double value) -> std::optional<double> {
        return rear(source) ? 3.0 * value : value;
      });
      EXPECT_EQ(spinning.integrity.flag(Source::wheel_rear_left), SourceFlag::slipping) << what();
      EXPECT_EQ(spinning.integrity.flag(Source::wheel_rear_right), SourceFlag::slipping) << what();
      EXPECT_EQ(spinning.integrity.flag(Source::wheel_front_left), SourceFlag::ok) << what();
    }
  }
}

TEST(Integrity, LowersAFlagWhenTheFaultIsGone) {
  Drive drive(slalom);
  drive.until(5.0);
  drive.until(6.0, offset(Source::yaw_rate, 1.5));
  EXPECT_EQ(drive.integrity.flag(Source::yaw_rate), SourceFlag::drifting);
  drive.until(6.5);
  EXPECT_EQ(drive.integrity.flag(Source::yaw_rate), SourceFlag::drifting);  // 0.5 s is not enough
  drive.until(8.0);
  EXPECT_EQ(drive.integrity.flag(Source::yaw_rate), SourceFlag::ok);
}

TEST(Integrity, AgreementOnAStraightSaysLittleOfAGyro) {
  const auto bend_then_straight = [](double t) { return Motion{1.5, t < 5.0 ? 0.3 : 0.0}; };
  const Failure inverted = failing(Source::yaw_rate, [](double, double value) { return -value; });
  Drive drive(bend_then_straight);
  drive.until(4.0);
  drive.until(8.0, inverted);
  EXPECT_EQ(drive.integrity.flag(Source::yaw_rate), SourceFlag::drifting);
  drive.until(14.0);
  EXPECT_EQ(drive.integrity.flag(Source::yaw_rate), SourceFlag::ok);
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

/// A car with one speed for its whole rear axle, a camera, and one more sensor of the turn.
class OneAxle {
 public:
  using Fails = std::function<double(double t, double value)>;

  OneAxle(Source sensor, std::function<double(double)> turn)
      : sensor_(sensor), turn_(std::move(turn)) {}

  void until(double end_s, const Fails& failure, bool camera_frozen = false) {
    for (; time_s() < end_s; ++ticks_) {
      const double turn = turn_(time_s());
      if (ticks_ % 2 == 0) {
        give(Source::wheel_rear, speed + 0.01 * std::sin(97.0 * time_s()));
        const double value =
            sensor_ == Source::steering ? std::atan(turn * Vehicle{}.wheelbase() / speed) : turn;
        give(sensor_, failure(time_s(), value));
      }
      yaw_ += 0.005 * turn;
      if (!camera_frozen) {
        seen_.x += 0.005 * speed * std::cos(yaw_);
        seen_.y += 0.005 * speed * std::sin(yaw_);
        seen_.yaw = yaw_;
      }
      if (ticks_ % 7 == 0) {
        seen_.arrival_ns = now_ns();
        seen_.capture_ns = now_ns() - 5 * ms;
        integrity.add(seen_);
      }
      integrity.check({}, now_ns());
    }
  }

  Integrity integrity;

 private:
  static constexpr double speed = 1.5;

  [[nodiscard]] double time_s() const { return 0.005 * static_cast<double>(ticks_); }
  [[nodiscard]] std::int64_t now_ns() const { return start_ns + 5 * ticks_ * ms; }
  void give(Source source, double value) {
    integrity.add(source, now_ns() - ms, value, sigmas[index_of(source)]);
  }

  Source sensor_;
  std::function<double(double)> turn_;
  std::int64_t ticks_ = 0;
  double yaw_ = 0.0;
  CameraPose seen_{.sigma_x = 0.008, .sigma_y = 0.008, .sigma_yaw = 0.009};
};

TEST(Integrity, DetectsFrozenSourcesByTheCameraAlone) {
  for (const Source source : {Source::yaw_rate, Source::steering}) {
    OneAxle drive(source, [](double t) { return 0.8 * std::sin(1.3 * t); });
    drive.until(4.0, [](double, double value) { return value; });
    EXPECT_EQ(drive.integrity.flag(source), SourceFlag::ok) << source_names[index_of(source)];
    std::optional<double> held;
    drive.until(6.5, [&](double, double value) {
      held = held.value_or(value);
      return *held;
    });
    EXPECT_EQ(drive.integrity.flag(source), SourceFlag::frozen) << source_names[index_of(source)];
    EXPECT_EQ(drive.integrity.flag(Source::camera), SourceFlag::ok);
    EXPECT_EQ(drive.integrity.flag(Source::wheel_rear), SourceFlag::ok);
  }
}

TEST(Integrity, IfBothRepeatFlagsTheCameraThatSeesNoMotion) {
  // In a long bend, a steering that is held still repeats its value without a fault.
  for (const Source source : {Source::yaw_rate, Source::steering}) {
    OneAxle drive(source, [](double) { return 0.8; });
    const auto all_well = [](double, double value) { return value; };
    drive.until(4.0, all_well);
    drive.until(8.0, all_well, true);
    EXPECT_EQ(drive.integrity.flag(source), SourceFlag::ok) << source_names[index_of(source)];
    EXPECT_EQ(drive.integrity.flag(Source::camera), SourceFlag::frozen)
        << source_names[index_of(source)];
  }
}

TEST(Integrity, DetectsAFrozenCamera) {
  Drive drive(slalom, {.camera = true});
  drive.until(8.0);
  drive.freeze_camera();
  drive.until(9.5);
  EXPECT_EQ(drive.integrity.flag(Source::camera), SourceFlag::frozen);
  EXPECT_EQ(drive.flagged(), 1);
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
  EXPECT_EQ(drive.integrity.flag(Source::yaw_rate), SourceFlag::frozen);
}

TEST(Integrity, ASilentSourceRegainsNoTrust) {
  Drive drive(slalom);
  const auto fails = [](Source source, double t, double value) -> std::optional<double> {
    if (source != Source::yaw_rate || t < 5.0) return value;
    return t < 7.0 ? std::optional(value + 1.0) : std::nullopt;
  };
  drive.until(15.0, fails);
  EXPECT_FALSE(drive.integrity.trusted(Source::yaw_rate));
}

TEST(Integrity, TakesNoMemory) {
  // Unsigned wheels and a failing gyro exercise all of the checks.
  Drive drive(slalom, {.unsigned_wheels = true});
  drive.until(2.0);
  const Failure fails = [](Source source, double, double value) -> std::optional<double> {
    return source == Source::yaw_rate ? value + 1.0 : value;
  };
  const auto before = allocation_count();
  drive.until(4.0, fails);
  EXPECT_EQ(allocation_count(), before);
  EXPECT_FALSE(drive.integrity.trusted(Source::yaw_rate));
}

// A wheel that spins up as no car can and comes back, and a wheel that follows a braking car.
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

TEST(Integrity, AGyroOfTheWrongSignIsNoReversing) {
  const auto from_rest = [](double t) {
    return Motion{1.5 * std::clamp(t - 2.0, 0.0, 1.0), t < 4.0 ? 0.0 : 0.3 * std::sin(1.3 * t)};
  };
  Drive drive(from_rest, {.unsigned_wheels = true});
  drive.until(12.0, [](Source source, double, double value) -> std::optional<double> {
    return source == Source::yaw_rate ? -value : value;
  });
  EXPECT_FALSE(drive.integrity.backwards());
  EXPECT_NEAR(drive.integrity.motion().motion[integrity::of::speed], 1.5, 0.1);
  EXPECT_TRUE(drive.raised_s(Source::yaw_rate));
  EXPECT_EQ(drive.flagged(), 1);
}

}  // namespace
}  // namespace odomd::estimator::integrity_test
