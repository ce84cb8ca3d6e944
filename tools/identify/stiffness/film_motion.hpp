// The motion of the car in the film from above: centre of gravity and heading from two markers.
#pragma once

#include <cstdint>
#include <limits>
#include <optional>
#include <string>
#include <vector>

#include "daemon/diagnostics/diagnostic.hpp"
#include "tools/identify/common/signal_log.hpp"
#include "tools/identify/stiffness/marker_track.hpp"

namespace odomd::tools {

/// Where the markers are on the car: body frame, from the centre of gravity, x forward, y left [m].
struct MarkerPlaces {
  Plane front, rear;

  [[nodiscard]] double distance() const { return std::abs(front - rear); }
};

enum class ImageAxes : std::uint8_t { y_up, y_down };

/// The unit of the track.
struct FilmScale {
  enum class From : std::uint8_t { given, marker_distance };
  From from = From::marker_distance;
  double metres_per_unit = 1.0;  ///< where given; 1 for a track in metres
  double ratio_sigma = 0.01;  ///< where given: standard uncertainty of the markers' distance by it
  ImageAxes axes = ImageAxes::y_up;
};

struct BodyFrame {
  std::int64_t t_ns = 0;
  Plane centre;          ///< of gravity [m]
  double heading = 0.0;  ///< continuous [rad]
};

struct FilmMotion {
  std::vector<BodyFrame> frames;
  double metres_per_unit = 0.0;
  diagnostics::Diagnostics warnings;
};

/// Frames in which the markers are not as far apart as they are on the car are left out, and
/// counted in a warning; so is a scale that is given and contradicts the markers' distance by more
/// than three of its sigma. Throws std::invalid_argument if scale, places and film do not fit.
[[nodiscard]] FilmMotion film_motion(const MarkerTrack& track, const MarkerPlaces& places,
                                     const FilmScale& scale);

/// The motion about a time.
struct LocalMotion {
  Plane velocity;                 ///< of the centre of gravity, film axes [m/s]
  double heading = 0.0;           ///< [rad]
  double yaw_rate = 0.0;          ///< [rad/s]
  double heading_residual = 0.0;  ///< rms over the frames about the straight line [rad]
  std::size_t frames = 0;

  /// Velocity against the heading [rad].
  [[nodiscard]] double drift() const { return std::arg(velocity * std::polar(1.0, -heading)); }
};

/// Heading by a straight line, path by a circle at constant rate, p(τ) = c + q exp(i ψ̇ τ), over
/// the frames of [t - half, t + half]. Nothing if these are fewer than six, or leave a third of the
/// window uncovered.
[[nodiscard]] std::optional<LocalMotion> local_motion(const FilmMotion& motion, std::int64_t t_ns,
                                                      std::int64_t half_ns);

/// The yaw rates of a film or a gyro, smoothed alike, on a grid of step_ns: so they can be compared
/// [rad/s]; NaN where not known.
struct YawRates {
  static constexpr std::int64_t step_ns = 20'000'000;

  std::int64_t first_ns = 0;
  std::vector<double> value;

  [[nodiscard]] std::int64_t size() const { return static_cast<std::int64_t>(value.size()); }
  [[nodiscard]] double at(std::int64_t k) const {
    return k < 0 || k >= size() ? std::numeric_limits<double>::quiet_NaN()
                                : value[static_cast<std::size_t>(k)];
  }

  [[nodiscard]] static double seconds(std::int64_t steps) {
    return 1e-9 * static_cast<double>(steps * step_ns);
  }
};

[[nodiscard]] YawRates yaw_rates_of(const FilmMotion& motion);
[[nodiscard]] YawRates yaw_rates_of(const Series& gyro);

}  // namespace odomd::tools
