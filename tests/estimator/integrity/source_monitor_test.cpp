// The source monitor on a made-up drive: what each fault looks like, and what is none.
#include "estimator/integrity/source_monitor.hpp"

#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <functional>
#include <limits>
#include <optional>

#include "tests/allocation_count.hpp"

namespace odomd::estimator::source_monitor_test {
namespace {

constexpr std::int64_t ms = 1'000'000;
constexpr std::int64_t start_ns = 1'000'000 * ms;
constexpr double nan = std::numeric_limits<double>::quiet_NaN();

/// Of good sensors, in the order of Source.
constexpr std::array<double, source_count> sigmas{0.005, 0.15,  0.15,  0.007, 0.007,
                                                  0.007, 0.007, 0.007, 0.007, 0.002};

/// What the reference car does at a time [s].
struct Motion {
  double speed = 0.0;
  double steering = 0.0;
};

Motion slalom(double t) {
  return {1.5 + 0.3 * std::sin(0.7 * t), 0.3 * std::sin(1.3 * t)};
}

/// Replaces the true value of a source at a time.
using Failure = std::function<double(Source source, double t, double value)>;
double sound(Source, double, double value) {
  return value;
}

/// What the sensors are like beyond the usual: wheels that know no sign, a camera.
struct Equipment {
  bool unsigned_wheels = false;
  bool camera = false;
  std::optional<double> direction = std::nullopt;  ///< what is said of it, throughout
};

class Drive {
 public:
  explicit Drive(std::function<Motion(double)> motion, Equipment equipment = {})
      : motion_(std::move(motion)), equipment_(equipment) {}

  /// Drives on, with a sample of every source each 10 ms.
  void until(double end_s, const Failure& failure = sound) {
    for (; time_s() < end_s; now_ns_ += 5 * ms) {
      const double t = time_s();
      if (now_ns_ / ms % 10 == 0) sense(t, failure);
      if (equipment_.camera) look(t);
      monitor.step(now_ns_);
      for (std::size_t i = 0; i < source_count; ++i)
        if (!raised_s_[i] && monitor.flag(static_cast<Source>(i)) != SourceFlag::ok)
          raised_s_[i] = t;
    }
  }

  /// When the first flag of a source was raised.
  [[nodiscard]] std::optional<double> raised_s(Source source) const {
    return raised_s_[static_cast<std::size_t>(source)];
  }
  [[nodiscard]] int flagged() const {
    int count = 0;
    for (const auto& raised : raised_s_) count += raised ? 1 : 0;
    return count;
  }

  /// From now on it shows the same picture.
  void freeze_camera() { camera_frozen_ = true; }

  SourceMonitor monitor{Vehicle{}, sigmas};

 private:
  [[nodiscard]] double time_s() const { return static_cast<double>(now_ns_ - start_ns) * 1e-9; }

  void sense(double t, const Failure& failure) {
    const Vehicle car;
    const auto [v, delta] = motion_(t);
    const double turn = v * std::tan(delta) / car.wheelbase();
    const double ahead = (motion_(t + 0.01).speed - motion_(t - 0.01).speed) / 0.02;
    const double half_track = 0.5 * car.track_width;
    // Moving sensors have noise; at rest they repeat.
    const double noise = v == 0.0 ? 0.0 : 0.01 * std::sin(97.0 * t);
    const auto give = [&](Source source, double value) {
      monitor.take(Measurement{.source = source,
                               .time_ns = now_ns_ - ms,
                               .value = failure(source, t, value),
                               .arrival_ns = now_ns_});
    };
    give(Source::yaw_rate, turn + noise);
    give(Source::accel_x, ahead + 10.0 * noise);
    give(Source::accel_y, v * turn - 10.0 * noise);
    const auto wheel = [&](double speed) {
      return equipment_.unsigned_wheels ? std::abs(speed) : speed;
    };
    give(Source::wheel_front_left, wheel((v - half_track * turn) / std::cos(delta)));
    give(Source::wheel_front_right, wheel((v + half_track * turn) / std::cos(delta)));
    give(Source::wheel_rear_left, wheel(v - half_track * turn));
    give(Source::wheel_rear_right, wheel(v + half_track * turn));
    give(Source::steering, delta);
    if (equipment_.direction) give(Source::direction, *equipment_.direction);
  }

  /// Every 35 ms a pose, of the rear axle.
  void look(double t) {
    const auto [v, delta] = motion_(t);
    const double way = camera_frozen_ ? 0.0 : 0.005 * v;
    seen_.yaw += way * std::tan(delta) / Vehicle{}.wheelbase();
    seen_.x += way * std::cos(seen_.yaw);
    seen_.y += way * std::sin(seen_.yaw);
    if (now_ns_ / ms % 35 != 0) return;
    seen_.capture_ns = now_ns_ - 5 * ms;
    seen_.arrival_ns = now_ns_;
    monitor.take(seen_);
  }

  std::function<Motion(double)> motion_;
  Equipment equipment_;
  bool camera_frozen_ = false;
  CameraPose seen_{.sigma_x = 0.008, .sigma_y = 0.008, .sigma_yaw = 0.009};
  std::int64_t now_ns_ = start_ns;
  std::array<std::optional<double>, source_count> raised_s_{};
};

Failure failing(Source which, const std::function<double(double t, double value)>& how) {
  return [which, how](Source source, double t, double value) {
    return source == which ? how(t, value) : value;
  };
}

TEST(SourceMonitor, HasNothingToSayOfASlalom) {
  Drive drive(slalom);
  drive.until(60.0);
  EXPECT_EQ(drive.flagged(), 0);
}

TEST(SourceMonitor, TakesWheelsThatKnowNoSignForNoFaultInReverse) {
  // Backwards through a slalom, and hard on the brake and off it again.
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
  };
  nothing_of({.unsigned_wheels = true}, "alone");
  nothing_of({.unsigned_wheels = true, .camera = true}, "with camera");
  nothing_of({.unsigned_wheels = true, .camera = true, .direction = -1.0}, "told so");
  nothing_of({.unsigned_wheels = true, .camera = true, .direction = 0.0}, "not told");
}

TEST(SourceMonitor, TellsWhatFailsInReverseOfWheelsThatKnowNoSign) {
  const auto backwards = [](double t) {
    const Motion ahead = slalom(t);
    return Motion{-ahead.speed, ahead.steering};
  };
  const std::pair<Source, double> offsets[] = {
      {Source::yaw_rate, 1.5}, {Source::accel_y, 5.0}, {Source::wheel_rear_left, 1.5}};
  for (const auto& [source, offset] : offsets) {
    Drive drive(backwards, {.unsigned_wheels = true, .camera = true});
    drive.until(7.3);
    drive.until(
        8.0, failing(source, [offset = offset](double, double value) { return value + offset; }));
    EXPECT_NE(drive.monitor.flag(source), SourceFlag::ok) << source_names[index_of(source)];
    EXPECT_EQ(drive.flagged(), 1) << source_names[index_of(source)];
  }
}

TEST(SourceMonitor, TakesARestForNoFault) {
  Drive drive([](double t) { return t < 5.0 ? Motion{0.0, 0.2} : slalom(t); });
  drive.until(20.0);
  EXPECT_EQ(drive.flagged(), 0);
}

TEST(SourceMonitor, TakesASteadyDriveForNoFault) {
  Drive drive([](double) { return Motion{1.5, 0.1}; });  // wheels and steering repeat throughout
  drive.until(20.0);
  EXPECT_EQ(drive.flagged(), 0);
}

TEST(SourceMonitor, TellsWhatIsFrozen) {
  for (const Source source : {Source::yaw_rate, Source::accel_y, Source::steering,
                              Source::wheel_front_left, Source::wheel_rear_right}) {
    // At a time at which the car turns to one side.
    Drive drive(slalom);
    drive.until(6.0);
    std::optional<double> held;
    drive.until(10.5, failing(source, [&](double, double value) {
                  held = held.value_or(value);
                  return *held;
                }));
    EXPECT_EQ(drive.monitor.flag(source), SourceFlag::frozen)
        << source_names[static_cast<std::size_t>(source)];
    EXPECT_EQ(drive.flagged(), 1);
  }
}

TEST(SourceMonitor, TellsWhatContradictsTheOthersWithinHalfASecond) {
  const std::pair<Source, double> offsets[] = {
      {Source::yaw_rate, 1.5}, {Source::accel_y, 5.0}, {Source::accel_x, -5.0}};
  for (const auto& [source, offset] : offsets) {
    Drive drive(slalom);
    drive.until(7.3);
    drive.until(
        8.0, failing(source, [offset = offset](double, double value) { return value + offset; }));
    EXPECT_EQ(drive.monitor.flag(source), SourceFlag::drifting);
    ASSERT_TRUE(drive.raised_s(source));
    EXPECT_LT(*drive.raised_s(source), 7.8);
    EXPECT_EQ(drive.flagged(), 1);
  }
}

TEST(SourceMonitor, TellsALockedAndASpinningWheel) {
  for (const double factor : {0.0, 2.0}) {
    Drive drive(slalom);
    drive.until(7.3);
    drive.until(7.8, failing(Source::wheel_rear_left,
                             [factor](double, double value) { return factor * value; }));
    EXPECT_EQ(drive.monitor.flag(Source::wheel_rear_left), SourceFlag::slipping);
    EXPECT_EQ(drive.flagged(), 1);
  }
}

TEST(SourceMonitor, TellsTheAxleThatIsLockedUnderTheBrakeFromTheOneThatSpinsInBothDirections) {
  for (const bool unsigned_wheels : {false, true}) {
    for (const double direction : {1.0, -1.0}) {
      // On the brake from 5 s to 6 s, then on the throttle: front wheels locked, rear wheels
      // spinning.
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
      Drive locked(motion, equipment);
      locked.until(5.3);
      locked.until(5.7, [&](Source source, double, double value) {
        return front(source) ? 0.1 * value : value;
      });
      EXPECT_EQ(locked.monitor.flag(Source::wheel_front_left), SourceFlag::slipping);
      EXPECT_EQ(locked.monitor.flag(Source::wheel_front_right), SourceFlag::slipping);
      EXPECT_EQ(locked.monitor.flag(Source::wheel_rear_left), SourceFlag::ok);

      Drive spinning(motion, equipment);
      spinning.until(6.3);
      spinning.until(6.7, [&](Source source, double, double value) {
        return rear(source) ? 3.0 * value : value;
      });
      EXPECT_EQ(spinning.monitor.flag(Source::wheel_rear_left), SourceFlag::slipping);
      EXPECT_EQ(spinning.monitor.flag(Source::wheel_rear_right), SourceFlag::slipping);
      EXPECT_EQ(spinning.monitor.flag(Source::wheel_front_left), SourceFlag::ok);
    }
  }
}

TEST(SourceMonitor, TellsValuesThatAreNoneWithinThreePeriods) {
  for (const double value : {nan, 1e4}) {
    Drive drive(slalom);
    drive.until(3.0);
    drive.until(3.03, failing(Source::accel_y, [value](double, double) { return value; }));
    EXPECT_EQ(drive.monitor.flag(Source::accel_y),
              std::isnan(value) ? SourceFlag::non_finite : SourceFlag::out_of_range);
    drive.until(3.5);
    EXPECT_NE(drive.monitor.flag(Source::accel_y), SourceFlag::ok);  // not as soon as that
    drive.until(4.5);
    EXPECT_EQ(drive.monitor.flag(Source::accel_y), SourceFlag::ok);
  }
}

TEST(SourceMonitor, ForgivesASingleValue) {
  for (const double value : {nan, 1e4, 20.0}) {
    Drive drive(slalom);
    drive.until(3.0);
    drive.until(3.01, failing(Source::yaw_rate, [value](double, double) { return value; }));
    drive.until(5.0);
    EXPECT_EQ(drive.flagged(), 0);
  }
}

TEST(SourceMonitor, IsNotBlindedByAStampFromTheFuture) {
  Drive drive(slalom, {.camera = true});
  drive.until(3.0);
  drive.monitor.take(CameraPose{.capture_ns = start_ns + 60'000 * ms,
                                .arrival_ns = start_ns + 3'000 * ms,
                                .sigma_x = 0.01,
                                .sigma_y = 0.01,
                                .sigma_yaw = 0.01});
  drive.monitor.take(Measurement{.source = Source::yaw_rate,
                                 .time_ns = start_ns + 60'000 * ms,
                                 .value = 0.0,
                                 .arrival_ns = start_ns + 3'000 * ms});
  drive.until(7.3);
  drive.until(8.0, failing(Source::yaw_rate, [](double, double value) { return value + 1.5; }));
  EXPECT_EQ(drive.monitor.flag(Source::yaw_rate), SourceFlag::drifting);
  EXPECT_EQ(drive.flagged(), 1);
  drive.freeze_camera();
  drive.until(9.5);
  EXPECT_EQ(drive.monitor.flag(Source::camera), SourceFlag::frozen);
}

TEST(SourceMonitor, TakesAFlagBackWhenTheFaultIsGone) {
  Drive drive(slalom);
  drive.until(5.0);
  drive.until(6.0, failing(Source::yaw_rate, [](double, double value) { return value + 1.5; }));
  EXPECT_EQ(drive.monitor.flag(Source::yaw_rate), SourceFlag::drifting);
  drive.until(8.0);
  EXPECT_EQ(drive.monitor.flag(Source::yaw_rate), SourceFlag::ok);
}

TEST(SourceMonitor, BlamesNoneOfTwoThatContradictEachOther) {
  Drive drive(slalom);
  drive.until(5.0);
  const auto only_gyro_and_steering = [](double t, Source source, double value) {
    if (source == Source::yaw_rate || source == Source::steering) return value;
    return source == Source::wheel_rear_left || source == Source::wheel_rear_right ? slalom(t).speed
                                                                                   : nan;
  };
  // Two of an axle without their difference: no turn can be read from them either.
  drive.until(8.0, [&](Source source, double t, double value) {
    return source == Source::wheel_rear_right ? nan : only_gyro_and_steering(t, source, value);
  });
  drive.until(9.0, [&](Source source, double t, double value) {
    if (source == Source::yaw_rate) return value + 1.5;
    return source == Source::wheel_rear_right ? nan : only_gyro_and_steering(t, source, value);
  });
  EXPECT_EQ(drive.monitor.flag(Source::yaw_rate), SourceFlag::ok);
  EXPECT_EQ(drive.monitor.flag(Source::steering), SourceFlag::ok);
}

/// A car with one speed for its whole rear axle, a camera, and one more sensor that knows the turn.
class OneAxle {
 public:
  using Failure = std::function<double(double t, double value)>;

  OneAxle(Source sensor, std::function<double(double)> turn)
      : sensor_(sensor), turn_(std::move(turn)) {}

  void until(double end_s, const Failure& failure, bool camera_frozen = false) {
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
        monitor.take(seen_);
      }
      monitor.step(now_ns());
    }
  }

  SourceMonitor monitor{Vehicle{}, sigmas};

 private:
  static constexpr double speed = 1.5;

  [[nodiscard]] double time_s() const { return 0.005 * static_cast<double>(ticks_); }
  [[nodiscard]] std::int64_t now_ns() const { return start_ns + 5 * ticks_ * ms; }
  void give(Source source, double value) {
    monitor.take(Measurement{
        .source = source, .time_ns = now_ns() - ms, .value = value, .arrival_ns = now_ns()});
  }

  Source sensor_;
  std::function<double(double)> turn_;
  std::int64_t ticks_ = 0;
  double yaw_ = 0.0;
  CameraPose seen_{.sigma_x = 0.008, .sigma_y = 0.008, .sigma_yaw = 0.009};
};

TEST(SourceMonitor, TellsWhatIsFrozenByTheCameraAlone) {
  for (const Source source : {Source::yaw_rate, Source::steering}) {
    OneAxle drive(source, [](double t) { return 0.8 * std::sin(1.3 * t); });
    drive.until(4.0, [](double, double value) { return value; });
    EXPECT_EQ(drive.monitor.flag(source), SourceFlag::ok);
    std::optional<double> held;
    drive.until(6.5, [&](double, double value) {
      held = held.value_or(value);
      return *held;
    });
    EXPECT_EQ(drive.monitor.flag(source), SourceFlag::frozen)
        << source_names[static_cast<std::size_t>(source)];
    EXPECT_EQ(drive.monitor.flag(Source::camera), SourceFlag::ok);
    EXPECT_EQ(drive.monitor.flag(Source::wheel_rear), SourceFlag::ok);
  }
}

TEST(SourceMonitor, OfTwoThatBothRepeatBlamesTheCameraThatSeesNoMotion) {
  // In a long bend a steering that is held repeats, and rightly so.
  for (const Source source : {Source::yaw_rate, Source::steering}) {
    OneAxle drive(source, [](double) { return 0.8; });
    const auto sound = [](double, double value) { return value; };
    drive.until(4.0, sound);
    drive.until(8.0, sound, true);
    EXPECT_EQ(drive.monitor.flag(source), SourceFlag::ok)
        << source_names[static_cast<std::size_t>(source)];
    EXPECT_EQ(drive.monitor.flag(Source::camera), SourceFlag::frozen);
  }
}

TEST(SourceMonitor, TakesNoMemory) {
  Drive drive(slalom);
  drive.until(2.0);
  const auto before = allocation_count();
  for (int i = 0; i < 100; ++i) drive.monitor.step(start_ns + (3000 + 5 * i) * ms);
  EXPECT_EQ(allocation_count(), before);
}

}  // namespace
}  // namespace odomd::estimator::source_monitor_test
