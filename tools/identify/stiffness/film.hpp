// A film of the car from above: the tracks of two markers as tracking programs export them, the
// motion of the car, and when it was taken on the log's clock.
#pragma once

#include <complex>
#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <limits>
#include <optional>
#include <string>
#include <vector>

#include "daemon/diagnostics/diagnostic.hpp"
#include "tools/identify/common/signal_log.hpp"

namespace odomd::tools {

/// A point or a direction in the plane, x + i y: products turn.
using Plane = std::complex<double>;

/// A frame in which both markers were found; places in the track's unit and axes.
struct MarkerFrame {
  std::int64_t t_ns = 0;
  Plane front, rear;
};

struct MarkerTrack {
  std::string name;                 ///< of the file, for messages
  std::vector<MarkerFrame> frames;  ///< times strictly increasing
  std::size_t gaps = 0;             ///< rows without both markers
};

/// A file with the columns t, x_front, y_front, x_rear, y_rear, in any order; others are passed
/// over. Fields are parted by tabs, semicolons, commas or blanks; where commas do not part fields
/// they may be decimal ones. Lines before the first number are headings, the last of them names the
/// columns; "#" begins a comment. An empty field is a marker not seen. Throws std::invalid_argument
/// with file, line and column. `frames_per_second`: given, t holds frame numbers.
[[nodiscard]] MarkerTrack read_marker_track(const std::filesystem::path& file,
                                            std::optional<double> frames_per_second = {});

/// A file a marker, each with t, x, y; without headings in this order. Only times that both have
/// count.
[[nodiscard]] MarkerTrack read_marker_tracks(const std::filesystem::path& front,
                                             const std::filesystem::path& rear,
                                             std::optional<double> frames_per_second = {});

/// Where the markers are on the car: body frame, from the centre of gravity, x forward, y left [m].
struct MarkerPlaces {
  Plane front, rear;

  [[nodiscard]] double distance() const { return std::abs(front - rear); }
};

enum class ImageAxes : std::uint8_t { y_up, y_down };

/// The unit of the track.
struct FilmScale {
  std::optional<double>
      metres_per_unit;        ///< 1 for a track in metres; none: by the markers' distance
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

struct FilmAlignment {
  std::int64_t offset_ns = 0;  ///< log time = film time + offset, of the film's first frame
  double sigma_s = 0.0;        ///< standard uncertainty of the offset
  double rate = 0.0;  ///< by how much faster the log's clock runs: log seconds a film's - 1
  double rate_sigma = 0.0;
  double agreement = 0.0;  ///< 1: the yaw rates are the same; 0: as far off as their own size
  diagnostics::Diagnostics warnings;
};

/// Searches every shift at which a third of the shorter one of film and log overlaps, coarsely by
/// the mean square difference of the yaw rates, then refines by least squares with the gyro's scale
/// and bias and the rate of the film's clock left free. Within 0.3 % the rate is held to 0.1 %, as
/// clocks and nominal frame rates are; beyond it there is a warning. Throws std::invalid_argument
/// if film and log do not fit at any shift, with the likeliest reason: mirrored, another frame
/// rate, another drive. `name` is the film's. With
/// a shift that is known: the agreement and the rate there.
[[nodiscard]] FilmAlignment align_film(const std::string& name, const FilmMotion& motion,
                                       const Series& gyro,
                                       std::optional<std::int64_t> offset_ns = {});

/// Stretches the film's times about its first frame, to whose rate the log's clock runs.
void put_on_clock_of_log(const FilmAlignment& alignment, FilmMotion& motion);

}  // namespace odomd::tools
