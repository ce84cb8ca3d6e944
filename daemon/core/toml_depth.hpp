// Limits how deeply a TOML text is nested, before the library reads it: the library recurses, and a
// key with 50,000 dots would overflow the stack.
#pragma once

#include <filesystem>
#include <string_view>

namespace odomd::daemon {

/// More than twice what our files need: [can.signals] yaw_rate.valid_when.equals.
inline constexpr int deepest_key = 16;
inline constexpr int deepest_brackets = 16;

/// Throws ConfigError when a key has more parts, or more lists and tables are open. One pass.
void check_depth(std::string_view text, const std::filesystem::path& file);

}  // namespace odomd::daemon
