// Examines a running daemon by its status: rights that the machine refused, its beat, buses,
// sources and camera.
#pragma once

#include <nlohmann/json_fwd.hpp>

#include "daemon/diagnostics/diagnostic.hpp"
#include "tools/doctor/machine.hpp"

namespace odomd::tools::doctor {

/// `status` is the document of the status socket; `machine` shows whose limits to raise. Causes are
/// reported without their consequences: no late beat without real-time priority, no overdue signal
/// of a silent bus. The interfaces themselves are left to examine_link() (bus.hpp). Throws a
/// nlohmann::json::exception if a member has the wrong type.
[[nodiscard]] diagnostics::Diagnostics examine_daemon(const nlohmann::json& status,
                                                      const Machine& machine);

}  // namespace odomd::tools::doctor
