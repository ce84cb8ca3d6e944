// A film of the car from above: the tracks of two markers as tracking programs export them, the
// motion of the car, the film's time on the log's clock, and the steady circles.
#pragma once

#include <complex>
#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "daemon/diagnostics/diagnostic.hpp"
#include "tools/identify/common/measured.hpp"
#include "tools/identify/common/signal_log.hpp"

namespace odomd::tools {

/// A point or a direction in the plane, x + i y; multiplication rotates.
using Plane = std::complex<double>;

/// A frame with both markers; positions in the track's unit and axes.
struct MarkerFrame {
  std::int64_t t_ns = 0;
  Plane front, rear;
};

struct MarkerTrack {
  std::string name;                 ///< of the file, for messages
  std::vector<MarkerFrame> frames;  ///< times strictly increasing
  std::size_t gaps = 0;             ///< rows without both markers
};

/// Reads a CSV with the columns t [s], x_front, y_front, x_rear, y_rear, in any order; ignores
/// others. An empty field is an invisible marker. Throws std::invalid_argument with file, line and
/// column.
[[nodiscard]] MarkerTrack read_marker_track(const std::filesystem::path& file);

/// Positions of the markers: body frame, from the centre of gravity, x forward, y left [m].
struct MarkerPlaces {
  Plane front, rear;

  [[nodiscard]] double distance() const { return std::abs(front - rear); }
};

enum class ImageAxes : std::uint8_t { y_up, y_down };

/// The unit of the track.
struct FilmScale {
  std::optional<double> metres_per_unit;  ///< 1: track in metres; none: from the markers
  double ratio_sigma = 0.01;  ///< relative sigma of the markers' distance by metres_per_unit
  ImageAxes axes = ImageAxes::y_up;
};

struct BodyFrame {
  std::int64_t t_ns = 0;
  Plane centre;          ///< centre of gravity [m]
  double heading = 0.0;  ///< continuous [rad]
};

struct FilmMotion {
  std::vector<BodyFrame> frames;
  double metres_per_unit = 0.0;
  diagnostics::Diagnostics warnings;
};

/// Leaves out frames in which the distance of the markers is wrong, with a warning that counts
/// them. Also warns of a given scale that contradicts the markers' distance by more than three of
/// its sigma. Throws std::invalid_argument if scale, positions and film do not match.
[[nodiscard]] FilmMotion film_motion(const MarkerTrack& track, const MarkerPlaces& places,
                                     const FilmScale& scale);

/// The motion near a time.
struct LocalMotion {
  Plane velocity;                 ///< of the centre of gravity, in the film's axes [m/s]
  double heading = 0.0;           ///< [rad]
  double yaw_rate = 0.0;          ///< [rad/s]
  double heading_residual = 0.0;  ///< rms of the frames' deviations from the line [rad]
  std::size_t frames = 0;

  /// Direction of the velocity against the heading [rad].
  [[nodiscard]] double drift() const { return std::arg(velocity * std::polar(1.0, -heading)); }
};

/// Fits a straight line to the heading and a circle at constant rate, p(τ) = c + q exp(i ψ̇ τ), to
/// the path in [t - half, t + half]. Nothing if there are fewer than six frames, or if they leave a
/// third of the window uncovered.
[[nodiscard]] std::optional<LocalMotion> local_motion(const FilmMotion& motion, std::int64_t t_ns,
                                                      std::int64_t half_ns);

struct FilmAlignment {
  std::string film;            ///< its name
  std::int64_t offset_ns = 0;  ///< log time = film time + offset
  double sigma_s = 0.0;        ///< standard uncertainty of the offset at the film's begin
  diagnostics::Diagnostics warnings;
};

/// Tries every shift for which film and log overlap by a third of the shorter one, with the mean
/// square difference of the yaw rates, then refines the best (time_shift.hpp). Throws
/// std::invalid_argument if film and log match at no shift, with the likeliest reason: mirrored,
/// another frame rate, another drive. `name` is for messages.
[[nodiscard]] FilmAlignment align_film(const std::string& name, const FilmMotion& motion,
                                       const Series& gyro);

// Steady circles, and the measurements on each.

/// A stretch of steady turning: means over it, with standard uncertainties from their scatter. All
/// but steering, gyro and accelerometer come from the film. Left turns are positive.
struct CircleRun {
  std::string film;
  std::int64_t begin_ns = 0, end_ns = 0;  ///< film time
  double turned = 0.0;                    ///< [rad]
  double speed = 0.0;                     ///< of the centre of gravity [m/s]
  double yaw_rate = 0.0;                  ///< [rad/s]
  double lateral_accel = 0.0;             ///< v_x ψ̇ [m/s²]
  Measured drift;                         ///< direction of the velocity against the heading [rad]
  Measured steering;                      ///< from the log, at the front wheels [rad]
  Measured gyro;                          ///< yaw rate of the log [rad/s]
  Measured accelerometer;  ///< a_y of the log at the centre of gravity; sigma 0: none

  [[nodiscard]] double radius() const { return speed / std::abs(yaw_rate); }
};

/// The stretches of at least half a turn with speed and yaw rate within 6 %. Those with too little
/// steering data in the log are left out, with a warning. `imu_y`: position of the accelerometer to
/// the left of the centre of gravity [m].
[[nodiscard]] std::vector<CircleRun> measure_circles(const std::string& film,
                                                     const FilmMotion& motion, const SignalLog& log,
                                                     std::int64_t offset_ns, double imu_y,
                                                     diagnostics::Diagnostics& warnings);

}  // namespace odomd::tools
