// When the film was taken, on the log's clock: the shift at which the film's yaw rate lies on the
// gyro's.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "tools/identify/film_motion.hpp"
#include "tools/identify/signal_log.hpp"

namespace odomd::tools {

struct FilmAlignment {
  std::int64_t offset_ns = 0;  ///< log time = film time + offset
  double sigma_s = 0.0;        ///< standard uncertainty of the offset
  double agreement = 0.0;      ///< 1: the yaw rates are the same; 0: as far off as their own size
  std::vector<std::string> warnings;
};

/// Searches every shift at which a third of the shorter one of film and log overlaps, coarsely by
/// the mean square difference of the yaw rates, then refines by least squares with the gyro's scale
/// and bias left free. Throws std::invalid_argument where film and log do not fit at any shift,
/// with the likeliest reason: mirrored, another frame rate, another drive. `name` is the film's.
[[nodiscard]] FilmAlignment align_film(const std::string& name, const FilmMotion& motion,
                                       const Series& gyro);

/// The agreement at a shift that is known; throws as above.
[[nodiscard]] FilmAlignment check_alignment(const std::string& name, const FilmMotion& motion,
                                            const Series& gyro, std::int64_t offset_ns);

}  // namespace odomd::tools
