// What the subcommands of odom dbc do, and the forms that they share.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "can_protocol/frame.hpp"
#include "tools/cli/json_text.hpp"

namespace odomd::tools {

enum class OutputForm : std::uint8_t { readable, json };
enum class Frames : std::uint8_t { known, all };

/// Prints a database to standard output; warnings of its oddities go to standard error. Throws
/// std::invalid_argument for a file that is no database.
void show_dbc(const std::string& file, OutputForm form);

/// Decodes `log` ("-": standard input), a line a frame; of several databases the first that has an
/// identifier decodes it. Throws std::invalid_argument for unusable files.
void decode_log(const std::vector<std::string>& databases, const std::string& log, OutputForm form,
                Frames frames);

/// As candump prints it: 3 digits, or 8 of an extended one.
[[nodiscard]] std::string hexadecimal(std::uint32_t id, can::IdFormat format);

}  // namespace odomd::tools
