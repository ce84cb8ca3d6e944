#include <Eigen/Core>
#include <algorithm>
#include <cmath>
#include <optional>
#include <ranges>
#include <stdexcept>

#include <fmt/format.h>

#include "tools/cli/text.hpp"
#include "tools/diagnostics/kinds.hpp"
#include "tools/identify/common/agreement.hpp"
#include "tools/identify/stiffness/cornering_stiffness.hpp"
#include "tools/math/median.hpp"
#include "tools/math/se2.hpp"

namespace odomd::tools {
namespace {

using diagnostics::found;

// Beyond these limits the circles and the given data contradict each other.
constexpr double max_centre_shift = 0.03;     // shift of the centre of gravity / wheelbase
constexpr double max_steering_factor = 1.33;  // factor on the steering angle, or its inverse
constexpr double gross_scale_error = 0.15;    // |accelerometer / film - 1|

/// The log's lateral acceleration / the film's v_x ψ̇: shows a wrong scale of the film. Nothing if
/// there is too little data.
std::optional<Measured> accelerometer_slope(std::span<const CircleRun> circles) {
  std::vector<double> by_film, by_log;
  for (const CircleRun& run : circles) {
    if (!(run.accelerometer.sigma > 0.0)) continue;
    by_film.push_back(run.lateral_accel);
    by_log.push_back(run.accelerometer.value);
  }
  if (by_film.size() < 4) return std::nullopt;
  const Eigen::Map<const Eigen::ArrayXd> film(by_film.data(), std::ssize(by_film)),
      log(by_log.data(), std::ssize(by_log));
  const Relation relation = relation_of(log, film);
  const auto varies = [](const Eigen::ArrayXd& accel) {
    return (accel - accel.mean()).square().sum() > 1.0;
  };
  if (relation.slope == 0.0 || !(varies(film) || varies(log))) return std::nullopt;
  return Measured{relation.slope, relation.slope_sigma()};
}

// At any speed a car's wheels have about the angle that its circle needs: l ψ̇ / v.
void check_steering(std::span<const CircleRun> circles, double wheelbase) {
  constexpr double max_ratio = 4.0;
  std::vector<double> ratios;
  for (const CircleRun& run : circles)
    ratios.push_back(run.steering.value / std::atan(wheelbase * run.yaw_rate / run.speed));
  const double ratio = median_of(std::move(ratios));
  if (ratio > max_ratio || ratio < 1.0 / max_ratio)
    refuse(
        "{}: the log's steering is {:.3g} times the angle that the circles need: correct scale and "
        "unit of [can.signals] steering, which is the angle of the wheels; or the places of the "
        "markers (--front, --rear), which give the circles their size",
        circles.front().film, ratio);
}

}  // namespace

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
  const auto left =
      std::ranges::count_if(circles, [](const CircleRun& r) { return r.yaw_rate > 0; });
  if (left == 0 || left == std::ssize(circles))
    warnings.push_back(
        found(kind("circles_one_sided"), {},
              fmt::format("all circles turn to the {}: the steering's offset and the "
                          "angle of the markers cannot be separated from slip",
                          left == 0 ? "right" : "left"),
              left == 0 ? "left" : "right"));
  const auto [slow, fast] =
      std::ranges::minmax(circles | std::views::transform([](const CircleRun& r) {
                            return std::abs(r.lateral_accel);
                          }));
  if (slow > 0.5 * fast)
    add_warning(warnings, kind("circles_as_fast"), {},
                "all circles are about as fast: the steering's scale and the markers' "
                "places cannot be separated from slip");
  const std::optional<Measured> slope = accelerometer_slope(circles);
  const double off = slope ? std::abs(slope->value - 1.0) : 0.0;
  if (off > std::max(0.02, 3.0 * slope.value_or(Measured{}).sigma) && off <= gross_scale_error)
    add_warning(warnings, kind("film_acceleration_off"), "accel_y",
                "the accelerometer reads {:.1f} % of the film's lateral acceleration",
                100.0 * slope->value);
  return warnings;
}

void require_slip(const CorneringStiffness& found) {
  if (!found.front.is_undetermined() || !found.rear.is_undetermined()) return;
  double slip = 0.0, sigma = 0.0;
  for (const AxlePoint& point : found.rear.points) {
    slip = std::max(slip, std::abs(point.force) / found.rear.stiffness.value);
    sigma = std::max(sigma, point.sigma);
  }
  refuse(
      "the circles are too slow or too noisy: the largest slip angle is about {:.2f}°, and the "
      "film resolves {:.2f}°; drive faster, or film sharper and closer, with the markers farther "
      "apart and measured more precisely",
      degrees * slip,
      degrees * std::max(sigma, slip * found.rear.stiffness.sigma / found.rear.stiffness.value));
}

diagnostics::Diagnostics contradictions(const FilmedCircles& films, const CorneringStiffness& found,
                                        const CircleCar& car) {
  diagnostics::Diagnostics lines;
  const Measured& ahead = found.centre_ahead;
  if (std::abs(ahead.value) >
      std::max(4.0 * std::hypot(ahead.sigma, car.sigma_marker), max_centre_shift * car.wheelbase()))
    add_warning(
        lines, kind("centre_contradicted"), {},
        "according to the circles, the centre of gravity lies {:.3f} m {} the place in --front and "
        "--rear",
        std::abs(ahead.value), ahead.value > 0.0 ? "ahead of" : "behind");
  for (const Measured& scale : {found.steering_scale, found.free_steering_scale})
    if (lines.empty() &&
        (scale.value > max_steering_factor || scale.value < 1.0 / max_steering_factor))
      add_warning(
          lines, kind("steering_contradicted"), {},
          "the log's steering is {:.2f} times the angle of the wheels that the circles imply",
          scale.value);
  const auto slope = accelerometer_slope(films.circles);
  if (slope && std::abs(slope->value - 1.0) > std::max(gross_scale_error, 3.0 * slope->sigma))
    add_warning(lines, kind("film_acceleration_off"), {},
                "the accelerometer reads {:.0f} % of the film's lateral acceleration, and one "
                "of the two is wrong",
                100.0 * slope->value);
  const auto fitted = std::ranges::count(found.in_range, true);
  if (lines.empty() && 2 * found.used < static_cast<std::size_t>(fitted))
    add_warning(lines, kind("circles_off_curve"), {}, "of {} fitted {} lie on the curve",
                counted(static_cast<std::size_t>(fitted), "circle"), found.used);
  return lines;
}

}  // namespace odomd::tools
