// The folder of a simulated drive: drive.log, camera.csv, truth.csv, car.toml (the matching
// configuration), car.dbc, plant.json (the drawn truth), and on request the film's markers.csv.
// Also that of an experiment with a stationary car.
#pragma once

#include <cstdint>
#include <filesystem>
#include <fstream>
#include <string>

#include <nlohmann/json_fwd.hpp>

#include "tools/sim/simulation.hpp"

namespace odomd::sim {

/// The inputs of a daemon that runs on this drive.
struct Wiring {
  std::string can = "drive.log";        ///< [can] source: interface, log or "-"
  std::filesystem::path camera_socket;  ///< empty: the daemon's default
};

/// car.toml: the configuration of the simulated car, as its owner would write it, without knowing
/// the drawn errors.
[[nodiscard]] std::string configuration_text(const RunPlan& plan, const Wiring& wiring);

/// plant.json: the run, the sizes of its errors, and the drawn errors.
[[nodiscard]] nlohmann::ordered_json describe(const RunPlan& plan);

enum class Existing : std::uint8_t { keep, replace };

/// Makes the folder. Throws std::invalid_argument if that fails, or it is not empty and must be
/// kept.
void make_drive_folder(const std::filesystem::path& folder, Existing existing);

/// Writes car.toml, car.dbc and plant.json, each completely or not at all.
void write_car_files(const std::filesystem::path& folder, const RunPlan& plan,
                     const Wiring& wiring);

/// The name of the bus in a log.
inline constexpr const char* log_interface = "can0";

enum class FilmMarkers : std::uint8_t { leave_out, write };

/// Writes drive.log, camera.csv and truth.csv, and on request markers.csv. Throws
/// std::runtime_error if writing fails.
class DriveWriter {
 public:
  DriveWriter(const std::filesystem::path& folder, std::string interface,
              FilmMarkers film = FilmMarkers::leave_out);

  void write(const Happenings& happenings);

  /// Flushes and closes; must come last.
  void close();

 private:
  std::filesystem::path folder_;
  std::string interface_;
  std::ofstream log_, camera_, truth_, film_;
  std::string text_;
};

// Experiments with a stationary car, for identification (experiments.cpp). Each writes plant.json
// (the truth) and measured.json (a person's measurements). The car is that of a drive with the 1:10
// car and the same seed.

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
