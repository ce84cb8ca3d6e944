// The film from above: two markers on the car, tracked frame by frame in pixels.
#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <vector>

#include "tools/math/random.hpp"
#include "tools/sim/car/parameters.hpp"
#include "tools/sim/car/plant.hpp"

namespace odomd::sim {

struct MarkerPlace {
  double x = 0.0, y = 0.0;  ///< body frame, from the centre of gravity [m]
};

/// Where the markers' owner measured them to be.
struct MarkerPlaces {
  MarkerPlace front, rear;
};
[[nodiscard]] MarkerPlaces configured_markers(CarKind car);

/// A picture is 1920 x 1080; its u points to the map's -y and its v, downwards, to -x.
struct FilmFrame {
  double t_s = 0.0;  ///< by the film's clock, 0 at its first frame
  /// u, v of front and rear marker [px]; nothing where a marker is out of the picture.
  std::array<std::optional<std::array<double, 2>>, 2> markers;
};

class Film {
 public:
  Film(CarKind car, const ParameterSet& truth, std::uint64_t seed);

  /// Takes the frames that are due after `from_ns` and not after `to_ns`.
  void advance(std::int64_t from_ns, const PlantOutput& from, std::int64_t to_ns,
               const PlantOutput& to, std::vector<FilmFrame>& frames);

  /// Time of a frame on the car's clock.
  [[nodiscard]] std::int64_t frame_ns(std::int64_t frame) const;

 private:
  ParameterSet truth_;
  std::array<MarkerPlace, 2> markers_;
  RandomStream noise_;
  std::int64_t frame_ = 0;
};

}  // namespace odomd::sim
