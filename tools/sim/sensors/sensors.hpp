// The car's sensors: measurements of the true state, now or shortly before; and the cameras. Each
// has its own random streams and draws the same numbers whatever the sizes of its errors, so that a
// change of one error leaves all others unchanged.
#pragma once

#include <array>
#include <cmath>
#include <cstdint>
#include <deque>
#include <optional>
#include <string_view>
#include <vector>

#include "base/seconds.hpp"
#include "estimator/common/measurement.hpp"
#include "tools/math/random.hpp"
#include "tools/sim/car/parameters.hpp"
#include "tools/sim/car/plant.hpp"

namespace odomd::sim {

[[nodiscard]] inline std::int64_t nanoseconds(double s) {
  return std::llround(1e9 * s);
}
/// The resolution of stamps in logs.
[[nodiscard]] constexpr std::int64_t whole_microseconds(std::int64_t ns) {
  return ns / 1000 * 1000;
}

/// The car's past outputs, for sensors with latency.
class PastOutputs {
 public:
  /// Keeps the outputs of the last `reach_ns` before the second newest.
  explicit PastOutputs(std::int64_t reach_ns) : reach_ns_(reach_ns) {}

  /// Times must increase.
  void add(std::int64_t time_ns, const PlantOutput& output);

  [[nodiscard]] bool empty() const { return past_.empty(); }

  /// Interpolates at any time up to the newest output. Before the first output, returns that output
  /// with its wheels turned back at their rates.
  [[nodiscard]] PlantOutput at(std::int64_t time_ns) const;

 private:
  struct Past {
    std::int64_t time_ns = 0;
    PlantOutput output;
  };

  std::int64_t reach_ns_;
  std::deque<Past> past_;
};

/// A bias that starts at a drawn value and changes by a random walk.
class WalkingBias {
 public:
  /// `density` of the walk is in the bias's unit per √s.
  WalkingBias(double initial, double density, std::uint64_t seed, std::string_view stream)
      : value_(initial), density_(density), stream_(seed, stream) {}

  double after(double dt) {
    const double draw = stream_.normal();
    return value_ += density_ * std::sqrt(dt) * draw;
  }

 private:
  double value_;
  double density_;
  RandomStream stream_;
};

struct ImuReading {
  double yaw_rate = 0.0;  ///< [rad/s]
  double accel_x = 0.0;   ///< [m/s²], in the axes of the IMU
  double accel_y = 0.0;
};

class Imu {
 public:
  Imu(const ParameterSet& truth, std::uint64_t seed);

  /// `dt` since the last reading. `gyro_car`: the car one gyro latency ago; `car`: the car one
  /// accelerometer latency ago.
  ImuReading read(const PlantOutput& gyro_car, const PlantOutput& car, double dt);

 private:
  ParameterSet truth_;
  double on_for_ = 0.0;  // [s]
  WalkingBias gyro_bias_, accel_bias_x_, accel_bias_y_;
  RandomStream gyro_noise_, accel_noise_;
};

/// Counts the passing marks and divides by the time: quantised, without drift.
class WheelEncoder {
 public:
  WheelEncoder(const ParameterSet& truth, Wheel wheel, double configured_radius,
               std::uint64_t seed);

  /// Speed of the wheel [m/s]; `dt` since the last reading, on the control unit's clock. A
  /// stationary wheel, or one within the dead band, reads exactly 0.
  double read(const PlantOutput& car, double dt);

 private:
  [[nodiscard]] double quantised_turns(double angle) const;

  Wheel wheel_;
  double radius_;
  ParameterSet truth_;
  RandomStream stream_;
  double phase_;  ///< of the marks at wheel angle 0 [counts]
  std::optional<double> last_;
};

class SteeringSensor {
 public:
  SteeringSensor(const ParameterSet& truth, std::uint64_t seed);

  double read(const PlantOutput& car);

 private:
  ParameterSet truth_;
  RandomStream stream_;
};

/// Standard deviations that a configuration can state for these sensors.
[[nodiscard]] double wheel_speed_sigma(const ParameterSet& sizes, double configured_radius,
                                       double cycle_s);
[[nodiscard]] double steering_sigma(const ParameterSet& sizes);

// The cameras (camera.cpp). One next to the track sees the car's pose late, with noise and lasting
// errors, sometimes wrong, sometimes not at all; one above films two markers on the car.

/// No picture is taken from `begin` for `length` [s].
struct Dropout {
  double begin = 0.0, length = 0.0;
};

/// Parses "BEGIN:LENGTH" in seconds. Throws std::invalid_argument for other text.
[[nodiscard]] Dropout parse_dropout(std::string_view text);

class Camera {
 public:
  Camera(const ParameterSet& truth, std::vector<Dropout> dropouts, std::uint64_t seed);

  /// Takes the pictures that are due after `from_ns` and up to `to_ns`. Appends the poses of the
  /// reference point in map axes, in the order of arrival, which may be after `to_ns`.
  void advance(std::int64_t from_ns, const PlantOutput& from, std::int64_t to_ns,
               const PlantOutput& to, std::vector<estimator::CameraPose>& poses);

 private:
  void age_lasting_errors();

  ParameterSet truth_;
  std::vector<Dropout> dropouts_;
  RandomStream timing_, noise_, outliers_, lasting_noise_;
  std::array<double, 3> lasting_{};  // errors of x, y and yaw, in standard deviations
  std::int64_t due_ns_ = 0;
  std::int64_t last_arrival_ns_ = 0;
};

/// The positions of the front and the rear marker as their owner measured them, in the body frame,
/// from the centre of gravity.
[[nodiscard]] std::array<Vector2, 2> configured_markers(CarKind car);

/// A picture is 1920 x 1080; its u points to the map's -y, its v (downwards) to -x.
struct FilmFrame {
  double t_s = 0.0;  ///< on the film's clock, 0 at its first frame
  /// u, v of front and rear marker [px]; nothing if a marker is outside the picture.
  std::array<std::optional<std::array<double, 2>>, 2> markers;
};

class Film {
 public:
  Film(CarKind car, const ParameterSet& truth, std::uint64_t seed);

  /// Takes the frames that are due after `from_ns` and up to `to_ns`.
  void advance(std::int64_t from_ns, const PlantOutput& from, std::int64_t to_ns,
               const PlantOutput& to, std::vector<FilmFrame>& frames);

  /// The time of a frame on the car's clock.
  [[nodiscard]] std::int64_t frame_ns(std::int64_t frame) const;

 private:
  ParameterSet truth_;
  std::array<Vector2, 2> markers_;
  RandomStream noise_;
  std::int64_t frame_ = 0;
};

}  // namespace odomd::sim
