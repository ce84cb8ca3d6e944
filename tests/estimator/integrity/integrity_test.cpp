// Integrity on a simulated drive: detects each fault, and raises no flag without one.
#include "estimator/integrity/integrity.hpp"

#include <functional>
#include <optional>

#include "estimator/common/settings.hpp"
#include "tests/allocation_count.hpp"
#include "tests/gtest.hpp"

namespace odomd::estimator::integrity_test {
namespace {

constexpr std::int64_t ms = 1'000'000;
constexpr std::int64_t start_ns = 1'000'000 * ms;

/// Noise of good sensors, in the order of Source.
constexpr std::array<double, source_count> sigmas{0.005, 0.15,  0.15,  0.007, 0.007,
                                                  0.007, 0.007, 0.007, 0.007, 0.002};

/// Motion of the reference car at a time [s].
struct Motion {
  double speed = 0.0;
  double steering = 0.0;
};

Motion slalom(double t) {
  return {1.5 + 0.3 * std::sin(0.7 * t), 0.3 * std::sin(1.3 * t)};
}
Motion slalom_backwards(double t) {
  const Motion ahead = slalom(t);
  return {-ahead.speed, ahead.steering};
}

/// Replaces the true value of a source at a time; nothing: no sample.
using Failure = std::function<std::optional<double>(Source source, double t, double value)>;
std::optional<double> sound(Source, double, double value) {
  return value;
}

/// Optional sensors.
struct Equipment {
  bool unsigned_wheels = false;
  bool camera = false;
  std::optional<double> direction = std::nullopt;  ///< its constant value
};

class Drive {
 public:
  explicit Drive(std::function<Motion(double)> motion, Equipment equipment = {})
      : motion_(std::move(motion)), equipment_(equipment) {}

  /// Drives on, with a sample of every source every 10 ms.
  void until(double end_s, const Failure& failure = sound) {
    for (; time_s() < end_s; now_ns_ += 5 * ms) {
      const double t = time_s();
      if (now_ns_ / ms % 10 == 0) sense(t, failure);
      if (equipment_.camera) look(t);
      integrity.check({}, now_ns_);
      for (std::size_t i = 0; i < source_count; ++i)
        if (!raised_s_[i] && !integrity.trusted(static_cast<Source>(i))) raised_s_[i] = t;
    }
  }

  /// Time at which a source was first flagged [s].
  [[nodiscard]] std::optional<double> raised_s(Source source) const {
    return raised_s_[index_of(source)];
  }
  [[nodiscard]] int flagged() const {
    int count = 0;
    for (const auto& raised : raised_s_) count += raised ? 1 : 0;
    return count;
  }

  /// From now on the camera shows the same picture.
  void freeze_camera() { camera_frozen_ = true; }

  Integrity integrity;

 private:
  [[nodiscard]] double time_s() const { return static_cast<double>(now_ns_ - start_ns) * 1e-9; }

  void sense(double t, const Failure& failure) {
    const Vehicle car;
    const auto [v, delta] = motion_(t);
    const double turn = v * std::tan(delta) / car.wheelbase();
    const double ahead = (motion_(t + 0.01).speed - motion_(t - 0.01).speed) / 0.02;
    const double half_track = 0.5 * car.track_width;
    // On the move sensors have noise; at rest they repeat.
    const double noise = v == 0.0 ? 0.0 : 0.01 * std::sin(97.0 * t);
    const auto give = [&](Source source, double value) {
      if (const std::optional<double> sample = failure(source, t, value))
        integrity.add(source, now_ns_ - ms, *sample, sigmas[index_of(source)]);
    };
    give(Source::yaw_rate, turn + noise);
    give(Source::accel_x, ahead + 10.0 * noise);
    give(Source::accel_y, v * turn - 10.0 * noise);
    const auto wheel = [&](double speed) {
      if (!equipment_.unsigned_wheels) return speed;
      return equipment_.direction.value_or(0.0) < 0.0 ? -std::abs(speed) : std::abs(speed);
    };
    give(Source::wheel_front_left, wheel((v - half_track * turn) / std::cos(delta)));
    give(Source::wheel_front_right, wheel((v + half_track * turn) / std::cos(delta)));
    give(Source::wheel_rear_left, wheel(v - half_track * turn));
    give(Source::wheel_rear_right, wheel(v + half_track * turn));
    give(Source::steering, delta);
    if (equipment_.direction) give(Source::direction, *equipment_.direction);
  }

  /// Sends a pose of the rear axle every 35 ms.
  void look(double t) {
    const auto [v, delta] = motion_(t);
    const double way = camera_frozen_ ? 0.0 : 0.005 * v;
    seen_.yaw += way * std::tan(delta) / Vehicle{}.wheelbase();
    seen_.x += way * std::cos(seen_.yaw);
    seen_.y += way * std::sin(seen_.yaw);
    if (now_ns_ / ms % 35 != 0) return;
    seen_.capture_ns = now_ns_ - 5 * ms;
    seen_.arrival_ns = now_ns_;
    integrity.add(seen_);
  }

  std::function<Motion(double)> motion_;
  Equipment equipment_;
  bool camera_frozen_ = false;
  CameraPose seen_{.sigma_x = 0.008, .sigma_y = 0.008, .sigma_yaw = 0.009};
  std::int64_t now_ns_ = start_ns;
  std::array<std::optional<double>, source_count> raised_s_{};
};

Failure failing(Source which, const std::function<double(double t, double value)>& how) {
  return [which, how](Source source, double t, double value) -> std::optional<double> {
    return source == which ? how(t, value) : value;
  };
}
Failure offset(Source which, double by) {
  return failing(which, [by](double, double value) { return value + by; });
}

TEST(Integrity, HasNothingToSayOfASlalom) {
  for (const bool camera : {false, true}) {
    Drive drive(slalom, {.camera = camera});
    drive.until(60.0);
    EXPECT_EQ(drive.flagged(), 0);
    EXPECT_FALSE(drive.integrity.agreed().contradicted);
    EXPECT_NEAR(drive.integrity.motion().motion[integrity::of::speed], slalom(59.97).speed, 0.03);
    EXPECT_LT(drive.integrity.motion().sigma[integrity::of::speed], 0.1);
  }
}

TEST(Integrity, TakesWheelsThatKnowNoSignForNoFaultInReverse) {
  // Backwards through a slalom, repeatedly braking hard and releasing the brake.
  const auto backwards = [](double t) {
    const Motion ahead = slalom(t);
    return Motion{-ahead.speed - 0.8 * std::sin(4.0 * t), ahead.steering};
  };
  const auto nothing_of = [&](const Equipment& equipment, const char* what) {
    Drive drive(backwards, equipment);
    drive.until(30.0);
    for (std::size_t i = 0; i < source_count; ++i) {
      EXPECT_FALSE(drive.raised_s(static_cast<Source>(i)))
          << source_names[i] << " at " << drive.raised_s(static_cast<Source>(i)).value_or(0.0)
          << ", " << what;
    }
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
    EXPECT_GT(drive.integrity.motion().motion[integrity::of::speed], 1.0) << round;
    drive.until(12.0 * round + 8.0);
    EXPECT_TRUE(drive.integrity.backwards()) << round;
    EXPECT_LT(drive.integrity.motion().motion[integrity::of::speed], -1.0) << round;
    drive.until(12.0 * round + 12.0);
  }
  for (std::size_t i = 0; i < source_count; ++i)
    EXPECT_FALSE(drive.raised_s(static_cast<Source>(i)))
        << source_names[i] << " at " << drive.raised_s(static_cast<Source>(i)).value_or(0.0);
}

TEST(Integrity, DetectsFaultsInReverseWithUnsignedWheels) {
  const std::pair<Source, double> offsets[] = {
      {Source::yaw_rate, 1.5}, {Source::accel_y, 5.0}, {Source::wheel_rear_left, 1.5}};
  for (const auto& [source, by] : offsets) {
    Drive drive(slalom_backwards, {.unsigned_wheels = true, .camera = true});
    drive.until(7.3);
    drive.until(8.0, offset(source, by));
    EXPECT_NE(drive.integrity.flag(source), SourceFlag::ok) << source_names[index_of(source)];
    EXPECT_EQ(drive.flagged(), 1) << source_names[index_of(source)];
  }
}

TEST(Integrity, TakesARestForNoFault) {
  Drive drive([](double t) {
    // The car sets off at 1.5 m/s².
    const Motion going = slalom(t);
    return t < 5.0 ? Motion{0.0, 0.2}
                   : Motion{std::min(going.speed, 1.5 * (t - 5.0)), going.steering};
  });
  drive.until(20.0);
  EXPECT_EQ(drive.flagged(), 0);
}

TEST(Integrity, TakesASteadyDriveForNoFault) {
  Drive drive([](double) { return Motion{1.5, 0.1}; });  // wheels and steering repeat throughout
  drive.until(20.0);
  EXPECT_EQ(drive.flagged(), 0);
}

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
  const std::pair<Source, double> offsets[] = {
      {Source::yaw_rate, 1.5}, {Source::accel_y, 5.0}, {Source::accel_x, -5.0}};
  for (const auto& [source, by] : offsets) {
    Drive drive(slalom);
    drive.until(7.3);
    drive.until(8.0, offset(source, by));
    EXPECT_EQ(drive.integrity.flag(source), SourceFlag::drifting);
    ASSERT_TRUE(drive.raised_s(source)) << source_names[index_of(source)];
    EXPECT_LT(*drive.raised_s(source), 7.8) << source_names[index_of(source)];
    EXPECT_EQ(drive.flagged(), 1) << source_names[index_of(source)];
    // The consensus does not follow the faulty source.
    EXPECT_NEAR(drive.integrity.motion().motion[integrity::of::speed], slalom(8.0).speed, 0.1);
  }
}

TEST(Integrity, DetectsALockedAndASpinningWheel) {
  for (const double factor : {0.0, 2.0}) {
    Drive drive(slalom);
    drive.until(7.3);
    drive.until(7.8, failing(Source::wheel_rear_left,
                             [factor](double, double value) { return factor * value; }));
    EXPECT_NE(drive.integrity.flag(Source::wheel_rear_left), SourceFlag::ok);
    EXPECT_EQ(drive.flagged(), 1);
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

/// A car that spins off a corner, over its rear axle: β grows to a right angle and beyond, while
/// the driver countersteers.
TEST(Integrity, ASpinIsNoFaultOfTheSteering) {
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
    switch (source) {
      case Source::yaw_rate:
        return turn + 0.01 * std::sin(97.0 * t);
      case Source::accel_x:
        return (v_x(s + h) - v_x(s - h)) / (2.0 * h) - turn * v_y(s);
      case Source::accel_y:
        return (v_y(s + h) - v_y(s - h)) / (2.0 * h) + turn * v_x(s);
      case Source::wheel_front_left:
        return wheel(half_track, l, steering);
      case Source::wheel_front_right:
        return wheel(-half_track, l, steering);
      case Source::wheel_rear_left:
        return wheel(half_track, 0.0, 0.0);
      case Source::wheel_rear_right:
        return wheel(-half_track, 0.0, 0.0);
      case Source::steering:
        return steering;
      default:
        return value;
    }
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
    EXPECT_EQ(drive.flagged(), 0) << source_names[index_of(source)] << ' ' << value;
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

TEST(Integrity, AChangeDuringAGapIsAcceptedAfterwards) {
  // The car brakes from 30 m/s to 6 m/s while the bus is silent.
  const auto braking = [](double t) {
    return Motion{30.0 - 8.0 * std::clamp(t - 4.0, 0.0, 3.0) + 0.3 * std::sin(2.0 * t)};
  };
  Drive drive(braking);
  drive.until(10.0, [](Source, double t, double value) {
    return t < 4.0 || t > 7.0 ? std::optional(value) : std::nullopt;
  });
  EXPECT_NEAR(drive.integrity.motion().motion[integrity::of::speed], 6.0, 0.5);
  EXPECT_LT(drive.integrity.motion().sigma[integrity::of::speed], 0.1);
  for (std::size_t i = 0; i < source_count; ++i)
    EXPECT_TRUE(drive.integrity.trusted(static_cast<Source>(i))) << source_names[i];
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

TEST(Integrity, ASteeringCommandAtRestIsNotFrozen) {
  // The command rests at full lock on either side.
  const auto lock_to_lock = [](double t) {
    return Motion{1.0, std::clamp(0.6 * std::sin(0.8 * t), -0.3, 0.3)};
  };
  Drive drive(lock_to_lock);
  drive.until(30.0);
  EXPECT_EQ(drive.flagged(), 0);
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

}  // namespace
}  // namespace odomd::estimator::integrity_test
