// When the film was taken, on the log's clock: the shift at which the film's yaw rate lies on the
// gyro's.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "daemon/diagnostics/diagnostic.hpp"
#include "tools/identify/common/signal_log.hpp"
#include "tools/identify/stiffness/film_motion.hpp"

namespace odomd::tools {

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
/// rate, another drive. `name` is the film's.
[[nodiscard]] FilmAlignment align_film(const std::string& name, const FilmMotion& motion,
                                       const Series& gyro);

/// The agreement and the rate at a shift that is known; throws as above.
[[nodiscard]] FilmAlignment check_alignment(const std::string& name, const FilmMotion& motion,
                                            const Series& gyro, std::int64_t offset_ns);

/// Stretches the film's times about its first frame, to whose rate the log's clock runs.
void put_on_clock_of_log(const FilmAlignment& alignment, FilmMotion& motion);

}  // namespace odomd::tools
