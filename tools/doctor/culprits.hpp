// What the sensors show of themselves, before the replay blames one that contradicts it.
#pragma once

#include <optional>

#include "daemon/diagnostics/diagnostic.hpp"
#include "tools/identify/common/signal_log.hpp"
#include "tools/replay/drive.hpp"

namespace odomd::tools::doctor {

/// The camera's sigmas against its scatter, and sensors at the end of their range.
[[nodiscard]] diagnostics::Diagnostics find_culprits(const Drive& drive, const SignalLog& log);

}  // namespace odomd::tools::doctor
