// Programs in odom's folder that are linked with what they alone need: odom-bridge, odom-fit,
// odom-track. What odom is asked for is theirs to do.
#pragma once

#include <string>
#include <vector>

namespace odomd::tools {

/// Becomes that program. Throws std::runtime_error where it cannot be run: with `where_missing`,
/// which says how it is had, where it is not there.
[[noreturn]] void become(const std::string& program, std::vector<std::string> arguments,
                         const std::string& where_missing);

}  // namespace odomd::tools
