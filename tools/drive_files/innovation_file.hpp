// How every sample was judged, as a file: a row a sample, in the order in which the ticks took them
// in.
//
//   t         when the sample was taken [s], the log's clock
//   source    yaw_rate, ..., camera
//   verdict   fused, gated, ...
//   degrees   of freedom of the test: 1, of the camera 3; 0: not tested (an input, never taken in,
//             or a pose that was believed all the same)
//   nu_1..3   the innovation, in the source's units (camera: x, y [m], yaw [rad])
//   sigma_1..3  what the filter expected of it: the root of the diagonal of S
//   nis       νᵀS⁻¹ν
//
// Samples that a flood pushed out together have the time of the newest of them.
#pragma once

#include <filesystem>
#include <span>
#include <string>
#include <vector>

#include "estimator/common/measurement.hpp"

namespace odomd::tools {

[[nodiscard]] std::string innovation_header();
void append_innovation_rows(std::string& out, const estimator::Judgement& judgement);

/// Throws std::invalid_argument with file, line and column where it is not usable.
[[nodiscard]] std::vector<estimator::Judgement> read_innovations(const std::filesystem::path& file);

}  // namespace odomd::tools
