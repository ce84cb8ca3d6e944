#include "tools/sim/sensors/film.hpp"

#include <cmath>

namespace odomd::sim {
namespace {

using enum Parameter;

constexpr double width = 1920.0, height = 1080.0;

}  // namespace

MarkerPlaces configured_markers(CarKind car) {
  if (car == CarKind::scale_car) return {{0.18, 0.0}, {-0.12, 0.0}};
  return {{1.4, 0.0}, {-1.6, 0.0}};
}

Film::Film(CarKind car, const ParameterSet& truth, std::uint64_t seed)
    : truth_(truth), noise_(seed, "noise of the film") {
  const MarkerPlaces places = configured_markers(car);
  markers_ = {
      MarkerPlace{places.front.x + truth[marker_error_front_x],
                  places.front.y + truth[marker_error_front_y]},
      MarkerPlace{places.rear.x + truth[marker_error_rear_x],
                  places.rear.y + truth[marker_error_rear_y]},
  };
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
      const MarkerPlace& place = markers_[i];
      const double x = car.x + c * place.x - s * place.y;
      const double y = car.y + s * place.x + c * place.y;
      const double u = 0.5 * width - y / truth_[film_pixel] + truth_[film_noise] * noise_.normal();
      const double v = 0.5 * height - x / truth_[film_pixel] + truth_[film_noise] * noise_.normal();
      if (u >= 0.0 && u < width && v >= 0.0 && v < height) frame.markers[i] = {u, v};
    }
  }
}

}  // namespace odomd::sim
