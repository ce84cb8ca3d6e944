// Diagnostics as the commands show them: lines on standard error, or JSON.
#pragma once

#include <nlohmann/json_fwd.hpp>
#include <string>

#include "daemon/diagnostics/diagnostic.hpp"

namespace odomd::tools {

/// "odom replay: warning: lap.toml: ...", one line each; `command` is "replay", `whose` "lap.toml"
/// or empty.
void warn(const std::string& command, const diagnostics::Diagnostics& diagnostics,
          const std::string& whose = {});

/// An array of objects: code, name, subject, seen, fix.
[[nodiscard]] nlohmann::ordered_json as_json(const diagnostics::Diagnostics& diagnostics);

}  // namespace odomd::tools
