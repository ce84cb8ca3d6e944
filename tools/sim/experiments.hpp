// Experiments with a standing car, for identification: what is drawn, what is measured and how
// precisely. Each writes plant.json (the truth) and measured.json (what a person wrote down). The
// car is the one that a drive of the 1:10 car with the same seed drives: one afternoon is one seed.
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

/// The car on two cords: drive.log with its gyro, truth.csv, car.toml, car.dbc; measured.json holds
/// lengths, mass and timings by stop-watch. Returns what was measured.
nlohmann::ordered_json simulate_swing(const ExperimentOptions& options);

/// The car on a kitchen scale, on slopes of its own: measured.json holds the weighings.
nlohmann::ordered_json simulate_weighing(const ExperimentOptions& options);

}  // namespace odomd::sim
