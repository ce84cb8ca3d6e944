#include "tools/diagnostics/kinds.hpp"
#include "tools/identify/stiffness/stiffness.hpp"

#include <Eigen/Core>
#include <algorithm>
#include <cmath>
#include <stdexcept>
#include <utility>

#include <fmt/format.h>

#include "tools/identify/common/refuse.hpp"
#include "tools/identify/common/signal_log.hpp"
#include "tools/identify/stiffness/film.hpp"
#include "tools/math/median.hpp"

namespace odomd::tools {
namespace {

using diagnostics::found;
using tools::kind;

void measure_film(const StiffnessOptions& options, const daemon::Config& config,
                  const MarkerPlaces& places, const std::string& run, FilmedCircles& films) {
  const auto [tracks, log_file] = film_files(run);
  const FilmTime time{options.frames_per_second};
  const MarkerTrack track = tracks.size() == 1 ? read_marker_track(tracks[0], time)
                                               : read_marker_tracks(tracks[0], tracks[1], time);
  FilmMotion motion = film_motion(track, places, film_scale(options, places));
  append(films.warnings, motion.warnings);

  const std::vector<std::string> logs{log_file};
  const SignalLog log = read_signals(config, logs, options.damage);
  append(films.warnings, log.warnings);
  const Series& gyro = log.need(estimator::Source::yaw_rate);
  (void)log.need(estimator::Source::steering);
  std::optional<std::int64_t> offset_ns;
  if (options.time_offset) offset_ns = log.first_ns + std::llround(1e9 * *options.time_offset);
  FilmAlignment alignment = align_film(track.name, motion, gyro, offset_ns);
  append(films.warnings, alignment.warnings);
  put_on_clock_of_log(alignment, motion);
  alignment.offset_ns -= log.first_ns;  // what people can read

  const std::size_t warned = films.warnings.size();
  std::vector<CircleRun> circles =
      measure_circles(track.name, motion, log, alignment.offset_ns + log.first_ns,
                      config.imu_position[1], films.warnings);
  if (circles.empty() && films.warnings.size() == warned)
    films.warnings.push_back(found(kind("no_circle"), track.name, "contains no steady circle"));
  films.circles.insert(films.circles.end(), circles.begin(), circles.end());
  films.alignments.push_back(alignment);
  films.names.push_back(track.name);
}

void compare_accelerations(std::span<const CircleRun> circles, diagnostics::Diagnostics& warnings) {
  const std::optional<Measured> slope = accelerometer_slope(circles);
  const double off = slope ? std::abs(slope->value - 1.0) : 0.0;
  if (off > std::max(0.02, 3.0 * slope.value_or(Measured{}).sigma) && off <= gross_scale_error)
    warnings.push_back(
        found(kind("film_acceleration_off"), "accel_y",
              fmt::format("the accelerometer reads {:.1f} % of the film's lateral acceleration",
                          100.0 * slope->value)));
}

// Slow or fast, a car's wheels stand about as its circle needs: l ψ̇ / v.
void check_steering(std::span<const CircleRun> circles, double wheelbase) {
  constexpr double far_off = 4.0;
  std::vector<double> ratios;
  for (const CircleRun& run : circles)
    ratios.push_back(run.steering.value / std::atan(wheelbase * run.yaw_rate / run.speed));
  const double ratio = median_of(std::move(ratios));
  if (ratio > far_off || ratio < 1.0 / far_off)
    refuse(
        "{}: the log's steering is {:.3g} times the angle that the circles need: correct scale and "
        "unit of [can.signals] steering, which is the angle of the wheels; or the places of the "
        "markers (--front, --rear), which give the circles their size",
        circles.front().film, ratio);
}

void warn_of_what_is_missing(std::span<const CircleRun> circles,
                             diagnostics::Diagnostics& warnings) {
  const auto left =
      std::ranges::count_if(circles, [](const CircleRun& r) { return r.yaw_rate > 0; });
  if (left == 0 || left == std::ssize(circles))
    warnings.push_back(
        found(kind("circles_one_sided"), {},
              fmt::format("all circles turn to the {}: the steering's offset and the "
                          "angle of the markers cannot be separated from slip",
                          left == 0 ? "right" : "left"),
              left == 0 ? "left" : "right"));
  const auto [slow, fast] = std::ranges::minmax_element(
      circles, {}, [](const CircleRun& r) { return std::abs(r.lateral_accel); });
  if (std::abs(slow->lateral_accel) > 0.5 * std::abs(fast->lateral_accel))
    warnings.push_back(found(kind("circles_as_fast"), {},
                             "all circles are about as fast: the steering's scale and the markers' "
                             "places cannot be separated from slip"));
}

}  // namespace

FilmedCircles measure_films(const StiffnessOptions& options, const daemon::Config& config,
                            const MarkerPlaces& places) {
  FilmedCircles films;
  for (const std::string& run : options.runs) measure_film(options, config, places, run, films);
  if (films.circles.empty()) throw std::invalid_argument(text_of(films.warnings.back()));
  return films;
}

std::optional<Measured> accelerometer_slope(std::span<const CircleRun> circles) {
  std::vector<CircleRun> seen(circles.begin(), circles.end());
  std::erase_if(seen, [](const CircleRun& run) { return !(run.accelerometer.sigma > 0.0); });
  const auto n = static_cast<Eigen::Index>(seen.size());
  if (n < 4) return std::nullopt;
  Eigen::ArrayXd film(n), log(n);
  for (Eigen::Index i = 0; i < n; ++i) {
    film[i] = seen[static_cast<std::size_t>(i)].lateral_accel;
    log[i] = seen[static_cast<std::size_t>(i)].accelerometer.value;
  }
  film -= film.mean();
  log -= log.mean();
  const double spread = film.square().sum();
  if (!(spread > 0.0) || !(std::max(spread, log.square().sum()) > 1.0)) return std::nullopt;
  const double slope = (film * log).sum() / spread;
  // The residuals of the line give the uncertainty of its slope.
  const double residual = (log - slope * film).square().sum();
  return Measured{slope, std::sqrt(residual / (static_cast<double>(n - 2) * spread))};
}

void check_circles(std::span<const CircleRun> circles, double wheelbase) {
  std::size_t backwards = 0, sideways = 0, against = 0;
  for (const CircleRun& run : circles) {
    const double ahead = std::cos(run.drift.value);
    if (ahead < -0.3)
      ++backwards;
    else if (ahead < 0.3)
      ++sideways;
    if (run.steering.value * run.yaw_rate < 0.0) ++against;
  }
  if (2 * (backwards + sideways) > circles.size())
    throw std::invalid_argument(
        circles.front().film +
        (sideways > backwards
             ? ": the car moves sideways: --front and --rear are X,Y, forward and to the left of "
               "the centre of gravity; exchange the two numbers of each"
             : ": the car moves with its rear ahead: the markers are swapped (exchange --front and "
               "--rear, or the columns); circles in reverse cannot be used"));
  if (2 * against > circles.size())
    refuse(
        "{}: the car turns to the other side than it steers: correct the sign of [can.signals] "
        "steering (scale = -1.0); left is positive",
        circles.front().film);
  check_steering(circles, wheelbase);
}

diagnostics::Diagnostics circle_warnings(std::span<const CircleRun> circles) {
  diagnostics::Diagnostics warnings;
  warn_of_what_is_missing(circles, warnings);
  compare_accelerations(circles, warnings);
  return warnings;
}

}  // namespace odomd::tools
