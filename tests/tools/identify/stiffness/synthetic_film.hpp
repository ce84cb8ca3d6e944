// A film computed from a formula: a car stands, speeds up, circles and stops.
#pragma once

#include <cmath>
#include <functional>
#include <vector>

#include "tools/identify/common/signal_log.hpp"
#include "tools/identify/stiffness/film.hpp"

namespace odomd::tools {

/// Speed, yaw rate and drift (in the car's frame) over time [s].
struct SyntheticDrive {
  std::function<double(double)> speed;
  std::function<double(double)> yaw_rate;
  double drift = 0.0;

  /// Rises within 1 s after `begin`, falls within 1 s before `end`.
  static double eased(double t, double begin, double end) {
    const auto ramp = [](double x) {
      return x <= 0.0 ? 0.0 : x >= 1.0 ? 1.0 : 0.5 - 0.5 * std::cos(3.141592653589793 * x);
    };
    return ramp(t - begin) * ramp(end - t);
  }
};

struct SyntheticFilm {
  MarkerTrack track;
  Series gyro;
};

/// `duration` seconds of film at 60 Hz; the gyro at 200 Hz, its clock ahead by `offset_s`.
inline SyntheticFilm make_film(const SyntheticDrive& drive, const MarkerPlaces& places,
                               double duration, double offset_s, double metres_per_unit = 1.0) {
  constexpr double step = 1.0 / 1200.0;
  SyntheticFilm film;
  film.track.name = "film.csv";
  Plane centre{};
  double heading = 0.4;
  const auto steps = static_cast<int>(duration / step);
  for (int k = 0; k < steps; ++k) {
    const double t = k * step;
    if (k % 20 == 0) {
      const Plane turn = std::polar(1.0, heading);
      film.track.frames.push_back({std::llround(1e9 * t),
                                   (centre + turn * places.front) / metres_per_unit,
                                   (centre + turn * places.rear) / metres_per_unit});
    }
    if (k % 6 == 0) {
      film.gyro.add(std::llround(1e9 * (t + offset_s)), drive.yaw_rate(t));
    }
    const double middle = heading + 0.5 * step * drive.yaw_rate(t + 0.5 * step);
    centre += step * drive.speed(t + 0.5 * step) * std::polar(1.0, middle + drive.drift);
    heading += step * drive.yaw_rate(t + 0.5 * step);
  }
  return film;
}

}  // namespace odomd::tools
