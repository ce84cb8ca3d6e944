// Puts numbers into a configuration where they stand, so that everything else, comments too, stays
// as it was.
#pragma once

#include <filesystem>
#include <span>
#include <string>

namespace odomd::tools {

/// One number and its place: "vehicle.mass", "can.signals.yaw_rate.latency", "camera.lever_arm[2]".
struct ConfigValue {
  std::string key;
  double value = 0.0;
  std::string note;  ///< the comment beside it: "odom identify mass, 2 sigma 0.004 kg"
};

/// The text with the numbers in it: a value that is there is replaced where the parser says that
/// it stands, one that is missing is added to its table (also to an inline one), a missing table
/// at the end. Throws std::invalid_argument, naming file, line and key, where the text is no TOML
/// or a key holds something else than a number.
[[nodiscard]] std::string patched(const std::string& text, const std::filesystem::path& file,
                                  std::span<const ConfigValue> values);

/// Patches a file as a whole or not at all; the result must load as a configuration, or nothing is
/// written and the reason is thrown.
void patch_config(const std::filesystem::path& file, std::span<const ConfigValue> values);

}  // namespace odomd::tools
