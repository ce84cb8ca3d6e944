// Puts numbers into a configuration where they stand, so that everything else, comments too, stays
// as it was.
#pragma once

#include <filesystem>
#include <optional>
#include <span>
#include <string>

namespace odomd::tools {

/// One number and its place: "vehicle.mass", "can.signals.yaw_rate.latency", "camera.lever_arm[2]".
struct ConfigValue {
  std::string key;
  double value = 0.0;
  /// The comment at the end of its line: "odom identify mass: +- 0.004 kg, scale". It begins with
  /// "odom ", by which the next one is put in its place; everything else in comments stays. Where
  /// the line has several numbers, the note says which it is about: "(sigma: odom ...)".
  std::string note;
};

/// The text with the numbers in it: a value that is there is replaced where the parser says that
/// it stands, one that is missing is added to its table (also to an inline one), a missing table
/// at the end. Written in the shortest form that reads back to the same bits. Throws
/// std::invalid_argument, naming file, line and key, where the text is no TOML or a key holds
/// something else than a number.
[[nodiscard]] std::string patched(const std::string& text, const std::filesystem::path& file,
                                  std::span<const ConfigValue> values);

/// The number that stands there with odom's note about it; the note may be empty. Nothing where the
/// key is not there. Throws like patched().
[[nodiscard]] std::optional<ConfigValue> value_in(const std::string& text,
                                                  const std::filesystem::path& file,
                                                  const std::string& key);
[[nodiscard]] std::optional<ConfigValue> value_in(const std::filesystem::path& file,
                                                  const std::string& key);
[[nodiscard]] std::optional<double> number_in(const std::string& text,
                                              const std::filesystem::path& file,
                                              const std::string& key);
[[nodiscard]] std::optional<double> number_in(const std::filesystem::path& file,
                                              const std::string& key);

/// Throws what patch_config would of the file itself: missing, no regular file, no TOML, or in a
/// folder that cannot be written (std::runtime_error).
void check_patchable(const std::filesystem::path& file);

/// Patches a file as a whole or not at all; the result must load as a configuration, or nothing is
/// written and the reason is thrown. Mode and owner stay, and a link stays a link.
void patch_config(const std::filesystem::path& file, std::span<const ConfigValue> values);

}  // namespace odomd::tools
