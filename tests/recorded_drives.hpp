// Recorded drives and real databases, which are not part of the source tree: ODOMD_DRIVES names
// their folders, separated by ":".
#pragma once

#include <array>
#include <cstdio>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <optional>
#include <sstream>
#include <stdexcept>
#include <string>

namespace odomd::recorded {

/// The drives whose configurations are in tests/data/drives.
inline constexpr std::array drives{"dart_circles1",
                                   "dart_drift1",
                                   "dart_free1",
                                   "dart_free2",
                                   "dart_slow_steerid",
                                   "dart_tire1",
                                   "dart_track_v1",
                                   "genesis_slow",
                                   "ini_2025_12_17_07_40_02",
                                   "ini_2026_01_16_01_22_28",
                                   "ini_2026_01_16_01_45_24",
                                   "rav4",
                                   "revs_250lm"};
/// Drives with a car.toml in their own folder.
inline constexpr std::array drives_with_config{"cpm_ucar", "f110_ds3", "xray_duck_1"};

/// Whether ODOMD_DRIVES is set; if not, prints how many cases are skipped.
inline bool at_hand(std::size_t cases) {
  if (std::getenv("ODOMD_DRIVES") != nullptr) return true;
  std::printf("not run: %zu\n", cases);
  return false;
}

/// The folder with this name. Throws std::runtime_error, naming it, if there is none.
inline std::filesystem::path folder(const std::string& name) {
  const char* const listed = std::getenv("ODOMD_DRIVES");
  std::istringstream places(listed != nullptr ? listed : "");
  std::optional<std::filesystem::path> found;
  for (std::string place; std::getline(places, place, ':');) {
    if (!std::filesystem::is_directory(place))
      throw std::runtime_error("ODOMD_DRIVES: " + place + " is not a folder");
    const auto candidate = std::filesystem::path(place) / name;
    if (!found && std::filesystem::is_directory(candidate)) found = candidate;
  }
  if (!found) throw std::runtime_error("ODOMD_DRIVES: no folder " + name + " in " + places.str());
  return *found;
}

/// The configuration of a drive: its own, or that of its set (dart.toml for dart_free1).
inline std::filesystem::path config(const std::string& name) {
  const auto own = folder(name) / "car.toml";
  if (std::filesystem::exists(own)) return own;
  return std::filesystem::path(ODOMD_TEST_DATA) / "drives" /
         (name.substr(0, name.find('_')) + ".toml");
}

inline std::string text_of(const std::filesystem::path& file) {
  std::ifstream in(file, std::ios::binary);
  return {std::istreambuf_iterator<char>(in), std::istreambuf_iterator<char>()};
}

}  // namespace odomd::recorded
