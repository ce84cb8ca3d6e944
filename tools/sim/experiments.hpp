// Experiments with a stationary car, for identification. Each writes plant.json (the truth) and
// measured.json (a person's measurements). The car is that of a drive with the 1:10 car and the
// same seed.
#pragma once

#include <cstdint>
#include <filesystem>

#include <nlohmann/json_fwd.hpp>

#include "tools/sim/drive_folder.hpp"

namespace odomd::sim {

struct ExperimentOptions {
  std::filesystem::path folder;
  Existing existing = Existing::keep;
  std::uint64_t seed = 1;
  double duration = 180.0;  ///< of a swing [s]
};

/// The car on two cords: drive.log with its gyro, truth.csv, car.toml, car.dbc; measured.json has
/// lengths, amplitudes and stop-watch timings. Returns the measurements.
nlohmann::ordered_json simulate_swing(const ExperimentOptions& options);

/// The car on a kitchen scale, each time on another slight slope: measured.json has the weighings.
nlohmann::ordered_json simulate_weighing(const ExperimentOptions& options);

}  // namespace odomd::sim
