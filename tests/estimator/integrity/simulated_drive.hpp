// A simulated drive for the integrity tests, with sensors that fail on demand.
#pragma once

#include <functional>
#include <optional>
#include <random>

#include "estimator/common/settings.hpp"
#include "estimator/integrity/integrity.hpp"
#include "tests/gtest.hpp"

namespace odomd::estimator::integrity_test {

inline constexpr std::int64_t ms = 1'000'000;
inline constexpr std::int64_t start_ns = 1'000'000 * ms;

/// Noise of good sensors, in the order of Source.
inline constexpr std::array<double, source_count> sigmas{0.005, 0.15,  0.15,  0.007, 0.007,
                                                         0.007, 0.007, 0.007, 0.007, 0.002};

/// Motion of the reference car at a time [s].
struct Motion {
  double speed = 0.0;
  double steering = 0.0;
};

inline Motion slalom(double t) {
  return {1.5 + 0.3 * std::sin(0.7 * t), 0.3 * std::sin(1.3 * t)};
}
inline Motion slalom_backwards(double t) {
  const Motion ahead = slalom(t);
  return {-ahead.speed, ahead.steering};
}

/// Replaces the true value of a source at a time; nothing: no sample.
using Failure = std::function<std::optional<double>(Source source, double t, double value)>;
inline std::optional<double> sound(Source, double, double value) {
  return value;
}

/// Optional sensors.
struct Equipment {
  bool unsigned_wheels = false;
  bool camera = false;
  /// The only sensor on the car besides the speed of the rear axle.
  std::optional<Source> alone = std::nullopt;
  std::optional<double> direction = std::nullopt;  ///< its constant value
  double outliers = 0.0;  ///< share of the camera's poses; up to 2 m off in x, y
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
      for (const Source source : all_sources)
        if (!raised_s(source) && !integrity.trusted(source)) raised_s_[index_of(source)] = t;
    }
  }

  /// Time at which a source was first flagged [s].
  [[nodiscard]] std::optional<double> raised_s(Source source) const {
    return raised_s_[index_of(source)];
  }
  /// All sources that have been flagged.
  [[nodiscard]] std::vector<std::string_view> flagged() const {
    std::vector<std::string_view> names;
    for (const Source source : all_sources)
      if (raised_s(source)) names.push_back(source_names[index_of(source)]);
    return names;
  }
  [[nodiscard]] SourceFlag flag(Source source) const { return integrity.flag(source); }
  [[nodiscard]] double speed() const { return integrity.motion().motion[integrity::of::speed]; }

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
      if (source != equipment_.alone.value_or(source) && source != Source::wheel_rear) return;
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
    if (equipment_.alone) give(Source::wheel_rear, v + noise);
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
    CameraPose pose = seen_;
    if (0.5 + 0.5 * off_(random_) < equipment_.outliers) {
      pose.x += 2.0 * off_(random_);
      pose.y += 2.0 * off_(random_);
    }
    integrity.add(pose);
  }

  std::function<Motion(double)> motion_;
  Equipment equipment_;
  std::mt19937 random_;
  std::uniform_real_distribution<double> off_{-1.0, 1.0};
  bool camera_frozen_ = false;
  CameraPose seen_{.sigma_x = 0.008, .sigma_y = 0.008, .sigma_yaw = 0.009};
  std::int64_t now_ns_ = start_ns;
  std::array<std::optional<double>, source_count> raised_s_{};
};

inline Failure failing(Source which, const std::function<double(double t, double value)>& how) {
  return [which, how](Source source, double t, double value) -> std::optional<double> {
    return source == which ? how(t, value) : value;
  };
}
inline Failure offset(Source which, double by) {
  return failing(which, [by](double, double value) { return value + by; });
}
/// Holds the first value.
inline Failure frozen(Source which) {
  return failing(which, [held = std::optional<double>()](double, double value) mutable {
    held = held.value_or(value);
    return *held;
  });
}

}  // namespace odomd::estimator::integrity_test
