// How deep a TOML text is nested, before the library reads it: its tables are built and taken down
// by recursion, and a key of 50,000 dots ends the process.
#pragma once

#include <filesystem>
#include <string_view>

namespace odomd::daemon {

/// Twice and more what any of our files needs: [can.signals] yaw_rate.valid_when.equals.
inline constexpr int deepest_key = 16;
inline constexpr int deepest_brackets = 16;

/// Throws ConfigError where a key has more parts, or more lists and tables are open. One pass.
void check_depth(std::string_view text, const std::filesystem::path& file);

}  // namespace odomd::daemon
