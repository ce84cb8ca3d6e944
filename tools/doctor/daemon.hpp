// A running daemon, from its status: what the machine refused it, its beat, buses, sources and
// camera.
#pragma once

#include <nlohmann/json_fwd.hpp>

#include "daemon/diagnostics/diagnostic.hpp"
#include "tools/doctor/machine.hpp"

namespace odomd::tools::doctor {

/// `status` is the document of the status socket; `machine` gives whose limits to raise. Causes
/// come without their consequences: no late beat without real-time priority, no overdue signal of
/// a silent bus. The interfaces themselves are left to examine_link() (bus.hpp). Throws a
/// nlohmann::json::exception where a member is of another type than it must be.
[[nodiscard]] diagnostics::Diagnostics examine_daemon(const nlohmann::json& status,
                                                      const Machine& machine);

}  // namespace odomd::tools::doctor
