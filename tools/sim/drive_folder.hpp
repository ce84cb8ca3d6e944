// The folder that a simulated drive is written to: drive.log, camera.csv, truth.csv, car.toml,
// car.dbc, plant.json, and where asked for the film's markers.csv.
#pragma once

#include <filesystem>
#include <fstream>
#include <string>

#include "can_protocol/sources/candump.hpp"
#include "tools/sim/car_files.hpp"
#include "tools/sim/simulation.hpp"

namespace odomd::sim {

enum class Existing : std::uint8_t { keep, replace };

/// Makes the folder. Throws std::invalid_argument where it cannot be one, or holds something and
/// that is to be kept.
void make_drive_folder(const std::filesystem::path& folder, Existing existing);

/// Writes car.toml, car.dbc and plant.json, each whole or not at all.
void write_car_files(const std::filesystem::path& folder, const RunPlan& plan,
                     const Wiring& wiring);

enum class FilmMarkers : std::uint8_t { leave_out, write };

/// drive.log, camera.csv and truth.csv, and markers.csv where asked for. Failing to write throws
/// std::runtime_error.
class DriveWriter {
 public:
  DriveWriter(const std::filesystem::path& folder, std::string interface,
              can::StampDecimals decimals, FilmMarkers film = FilmMarkers::leave_out);

  void write(const Happenings& happenings);

  /// Flushes and closes; must come last.
  void close();

 private:
  std::filesystem::path folder_;
  std::string interface_;
  can::StampDecimals decimals_;
  std::ofstream log_, camera_, truth_, film_;
  std::string text_;
};

}  // namespace odomd::sim
