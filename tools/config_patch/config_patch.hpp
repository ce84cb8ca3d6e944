// Writes numbers into a configuration in place, so that everything else, including comments, is
// kept.
#pragma once

#include <cstddef>
#include <filesystem>
#include <optional>
#include <span>
#include <string>
#include <string_view>

#include "daemon/core/config.hpp"

namespace odomd::tools {

/// One number and its place: "vehicle.mass", "can.signals.yaw_rate.latency", "camera.lever_arm[2]".
struct ConfigValue {
  std::string key;
  double value = 0.0;
  /// The comment at the end of its line: "odom identify mass: +- 0.004 kg, scale". It begins with
  /// "odom ", so that the next note replaces it; everything else in comments is kept. If the line
  /// has several numbers, the note says which one it is about: "(sigma: odom ...)".
  std::string note;
};

/// The text with the numbers: an existing value is replaced in place, a missing one is added to its
/// [table] or inline table, and a missing table is added at the end. Numbers are written in the
/// shortest form that reads back to the same bits. Throws std::invalid_argument, naming file, line
/// and key, if the text is not TOML, a key is not a number, or a number cannot be inserted because
/// its table is written as dotted keys or only implied by a [table.below].
[[nodiscard]] std::string patched(const std::string& text, const std::filesystem::path& file,
                                  std::span<const ConfigValue> values);

/// The current number, with odom's note about it, if there is one. Nothing if the key is missing.
/// Throws like patched().
[[nodiscard]] std::optional<ConfigValue> value_in(const std::string& text,
                                                  const std::filesystem::path& file,
                                                  const std::string& key);
[[nodiscard]] std::optional<ConfigValue> value_in(const std::filesystem::path& file,
                                                  const std::string& key);

/// A loaded configuration with these numbers, which keeps its logs and databases. Throws
/// std::invalid_argument if the result is not a valid configuration.
[[nodiscard]] daemon::Config config_with(const daemon::Config& config,
                                         std::span<const ConfigValue> values);

/// Throws std::invalid_argument if the file cannot be patched: it is missing, not a regular file,
/// not TOML or write-protected, or its folder cannot be written.
void check_patchable(const std::filesystem::path& file);

/// Patches a file completely or not at all: if the result does not load as a configuration, nothing
/// is written, and the reason is thrown. Mode, owner and symbolic links are kept.
void patch_config(const std::filesystem::path& file, std::span<const ConfigValue> values);

// Lines of the text of a TOML file and odom's notes in their comments, which no parser keeps
// (toml_lines.cpp). Each line is read on its own; the caller parses the result to detect a change
// inside a multi-line string.

/// The line that contains an offset: its begin, its comment (at the end if there is none), and its
/// end without the line break.
struct TomlLine {
  std::size_t begin = 0;
  std::size_t comment = 0;
  std::size_t end = 0;
};
[[nodiscard]] TomlLine toml_line(std::string_view text, std::size_t offset);

/// The offset of a position that the parser reported: line and character, both from 1.
[[nodiscard]] std::size_t toml_offset(std::string_view text, std::size_t line, std::size_t column);

/// Puts a note into the comment that ends the line with this offset, as "(note)" or "(label:
/// note)", replacing an earlier note of odom with that label; an empty note removes it. Everything
/// else in the comment is kept.
void set_toml_note(std::string& text, std::size_t offset, const std::string& label,
                   const std::string& note);

/// odom's note with that label in the comment that ends the line with this offset, without brackets
/// and label; empty if there is none.
[[nodiscard]] std::string toml_note(const std::string& text, std::size_t offset,
                                    const std::string& label);

/// A key as written in a file: in quotes if necessary.
[[nodiscard]] std::string toml_key(std::string_view key);

}  // namespace odomd::tools
