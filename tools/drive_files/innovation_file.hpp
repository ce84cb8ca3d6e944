// Writes and reads the filter's verdict on every sample: a file with a row per sample, in the order
// in which the ticks used them.
//
//   t         when the sample was taken [s], the log's clock
//   source    yaw_rate, ..., camera
//   verdict   fused, gated, ...
//   degrees   of freedom of the test: 1, camera 3; 0: not tested (an input, a sample never used, or
//             a pose that was accepted in spite of the test)
//   nu_1..3   the innovation, in the source's units (camera: x, y [m], yaw [rad])
//   sigma_1..3  expected standard deviations of nu: the roots of the diagonal of S
//   nis       νᵀS⁻¹ν
//
// Samples that were dropped together in a flood have the time of the newest of them.
#pragma once

#include <filesystem>
#include <span>
#include <string>
#include <vector>

#include "estimator/common/measurement.hpp"

namespace odomd::tools {

[[nodiscard]] std::string innovation_header();
void append_innovation_rows(std::string& out, const estimator::Judgement& judgement);

/// Throws std::invalid_argument with file, line and column if the file is not usable.
[[nodiscard]] std::vector<estimator::Judgement> read_innovations(const std::filesystem::path& file);

}  // namespace odomd::tools
