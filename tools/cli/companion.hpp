// Programs in odom's folder with large dependencies of their own: odom-bridge, odom-fit,
// odom-track. odom hands some commands over to them.
#pragma once

#include <string>
#include <vector>

namespace odomd::tools {

/// Replaces this process by that program. Throws std::runtime_error if it cannot be run; if it is
/// missing, with `where_missing`, which says how to install it.
[[noreturn]] void become(const std::string& program, std::vector<std::string> arguments,
                         const std::string& where_missing);

}  // namespace odomd::tools
