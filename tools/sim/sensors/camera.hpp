// The cameras. One next to the track sees the car's pose late, with noise and lasting errors,
// sometimes wrong, sometimes not at all; one above films two markers on the car.
#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <string_view>
#include <vector>

#include "estimator/common/measurement.hpp"
#include "tools/math/random.hpp"
#include "tools/sim/car/parameters.hpp"
#include "tools/sim/car/plant.hpp"

namespace odomd::sim {

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
