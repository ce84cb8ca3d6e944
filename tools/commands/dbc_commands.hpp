// The subcommands of odom dbc, and the formats that they share.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "can_protocol/frame.hpp"
#include "tools/cli/json_text.hpp"

namespace odomd::tools {

enum class OutputForm : std::uint8_t { readable, json };
enum class Frames : std::uint8_t { known, all };

/// Prints a database to standard output; its warnings go to standard error. Throws
/// std::invalid_argument for a file that is not a database.
void show_dbc(const std::string& file, OutputForm form);

/// Decodes `log` ("-": standard input), one line per frame; with several databases the first with
/// an identifier decodes it. Throws std::invalid_argument for unusable files.
void decode_log(const std::vector<std::string>& databases, const std::string& log, OutputForm form,
                Frames frames);

/// As candump prints it: 3 digits, or 8 for an extended identifier.
[[nodiscard]] std::string hexadecimal(std::uint32_t id, can::IdFormat format);

}  // namespace odomd::tools
