// Attaches to a daemon's segment, or reports in one line why that fails.
#pragma once

#include <odom/odom.hpp>
#include <string>

namespace odomd::tools {

/// The requested segment in words: the name, or the defaults.
[[nodiscard]] std::string segment_asked_for(const std::string& name);

/// `name` empty: the library's defaults. Tries again for `wait_s` seconds while there is no
/// segment. Throws std::invalid_argument for a name that is not usable, std::runtime_error else.
[[nodiscard]] odom::Client attach(const std::string& name, double wait_s);

}  // namespace odomd::tools
