#include "tools/sim/sensors/sensors.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <stdexcept>
#include <utility>

#include <fmt/format.h>

#include "tools/cli/csv.hpp"

namespace odomd::sim {
namespace {

using enum Parameter;

constexpr double width = 1920.0, height = 1080.0;

}  // namespace

Dropout parse_dropout(std::string_view text) {
  const std::size_t colon = std::min(text.find(':'), text.size());
  const auto begin = tools::parse_number(text.substr(0, colon));
  const auto length = tools::parse_number(text.substr(std::min(colon + 1, text.size())));
  if (!begin || !length || !(*begin >= 0.0) || !(*length > 0.0))
    throw std::invalid_argument(
        fmt::format("\"{}\": expected BEGIN:LENGTH in seconds, such as 20:2", text));
  return {*begin, *length};
}

Camera::Camera(const ParameterSet& truth, std::vector<Dropout> dropouts, std::uint64_t seed)
    : truth_(truth),
      dropouts_(std::move(dropouts)),
      timing_(seed, "latency of the camera"),
      noise_(seed, "noise of the camera"),
      outliers_(seed, "outliers of the camera"),
      lasting_noise_(seed, "lasting errors of the camera"),
      due_ns_(nanoseconds(timing_.uniform() * truth[camera_period])) {
  for (double& error : lasting_) error = lasting_noise_.normal();
}

// Gauss-Markov processes of variance 1: e_k = a e_(k-1) + √(1 - a²) n,  a = e^(-Δt/τ)
void Camera::age_lasting_errors() {
  const double a = std::exp(-truth_[camera_period] / truth_[camera_lasting_time]);
  for (double& error : lasting_)
    error = a * error + std::sqrt(1.0 - a * a) * lasting_noise_.normal();
}

void Camera::advance(std::int64_t from_ns, const PlantOutput& from, std::int64_t to_ns,
                     const PlantOutput& to, std::vector<estimator::CameraPose>& poses) {
  for (; due_ns_ <= to_ns; due_ns_ += nanoseconds(truth_[camera_period])) {
    // Rounded like a stamp: a stamp without a delay is then the exact time of the picture.
    const std::int64_t capture_ns = whole_microseconds(due_ns_);
    const PlantOutput car = interpolate(
        from, to, static_cast<double>(capture_ns - from_ns) / static_cast<double>(to_ns - from_ns));
    const double x = truth_[camera_x], y = truth_[camera_y];
    const double c = std::cos(car.yaw), s = std::sin(car.yaw);

    // All numbers are drawn, needed or not.
    age_lasting_errors();
    const double latency = timing_.uniform(truth_[camera_latency_min], truth_[camera_latency_max]);
    const double noise_x = noise_.normal(), noise_y = noise_.normal(), noise_yaw = noise_.normal();
    const bool outlier = outliers_.uniform() < truth_[camera_outliers];
    const double astray = truth_[camera_outlier_size] * outliers_.uniform();
    const double direction = 2.0 * std::numbers::pi * outliers_.uniform();

    const double second = seconds(capture_ns);
    const bool blind = std::ranges::any_of(dropouts_, [second](const Dropout& d) {
      return second >= d.begin && second < d.begin + d.length;
    });
    if (blind) continue;

    estimator::CameraPose pose;
    pose.capture_ns = whole_microseconds(capture_ns + nanoseconds(truth_[camera_stamp_delay]));
    pose.arrival_ns = std::max(whole_microseconds(pose.capture_ns + nanoseconds(latency)),
                               last_arrival_ns_ + 1000);
    last_arrival_ns_ = pose.arrival_ns;
    const double lasting = truth_[camera_lasting_noise];
    const double lasting_yaw = truth_[camera_lasting_yaw_noise];
    pose.x = car.x + c * x - s * y + truth_[camera_noise] * noise_x + lasting * lasting_[0];
    pose.y = car.y + s * x + c * y + truth_[camera_noise] * noise_y + lasting * lasting_[1];
    pose.yaw = std::remainder(car.yaw + truth_[camera_yaw] + truth_[camera_yaw_noise] * noise_yaw +
                                  lasting_yaw * lasting_[2],
                              2.0 * std::numbers::pi);
    if (outlier) {
      pose.x += astray * std::cos(direction);
      pose.y += astray * std::sin(direction);
    }
    // The sigmas are correct, but the correlation of the lasting errors is not stated.
    pose.sigma_x = pose.sigma_y = std::max(std::hypot(truth_[camera_noise], lasting), 1e-3);
    pose.sigma_yaw = std::max(std::hypot(truth_[camera_yaw_noise], lasting_yaw), 1e-3);
    poses.push_back(pose);
  }
}

std::array<Vector2, 2> configured_markers(CarKind car) {
  if (car == CarKind::scale_car) return {{{0.18, 0.0}, {-0.12, 0.0}}};
  return {{{1.4, 0.0}, {-1.6, 0.0}}};
}

Film::Film(CarKind car, const ParameterSet& truth, std::uint64_t seed)
    : truth_(truth), markers_(configured_markers(car)), noise_(seed, "noise of the film") {
  markers_[0].x += truth[marker_error_front_x];
  markers_[0].y += truth[marker_error_front_y];
  markers_[1].x += truth[marker_error_rear_x];
  markers_[1].y += truth[marker_error_rear_y];
}

std::int64_t Film::frame_ns(std::int64_t frame) const {
  const double film_s = static_cast<double>(frame) / truth_[film_rate];
  return std::llround(1e9 *
                      (std::abs(truth_[film_begin]) + film_s / (1.0 + truth_[film_clock_error])));
}

void Film::advance(std::int64_t from_ns, const PlantOutput& from, std::int64_t to_ns,
                   const PlantOutput& to, std::vector<FilmFrame>& frames) {
  for (; frame_ns(frame_) <= to_ns; ++frame_) {
    const PlantOutput car = interpolate(
        from, to,
        static_cast<double>(frame_ns(frame_) - from_ns) / static_cast<double>(to_ns - from_ns));
    FilmFrame& frame = frames.emplace_back();
    frame.t_s = static_cast<double>(frame_) / truth_[film_rate];
    const double c = std::cos(car.yaw), s = std::sin(car.yaw);
    for (std::size_t i = 0; i < markers_.size(); ++i) {
      const Vector2& place = markers_[i];
      const double x = car.x + c * place.x - s * place.y;
      const double y = car.y + s * place.x + c * place.y;
      const double u = 0.5 * width - y / truth_[film_pixel] + truth_[film_noise] * noise_.normal();
      const double v = 0.5 * height - x / truth_[film_pixel] + truth_[film_noise] * noise_.normal();
      if (u >= 0.0 && u < width && v >= 0.0 && v < height) frame.markers[i] = {u, v};
    }
  }
}

}  // namespace odomd::sim
