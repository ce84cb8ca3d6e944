// All kinds of diagnostics: those of the daemon, and those that only tools give.
// docs/diagnostics.md is generated from them.
#pragma once

#include "daemon/diagnostics/diagnostic.hpp"
#include "tools/diagnostics/identification.hpp"
#include "tools/diagnostics/machine.hpp"
#include "tools/drive_files/pose_kinds.hpp"

namespace odomd::tools {

/// In the order of the codes.
inline constexpr std::array all_chapters{
    diagnostics::chapters[0],
    diagnostics::chapters[1],
    diagnostics::chapters[2],
    diagnostics::pose_chapter,
    diagnostics::Chapter{"Identification", diagnostics::identification},
    diagnostics::Chapter{"The machine", diagnostics::machine},
    diagnostics::Chapter{"CAN buses", diagnostics::bus},
    diagnostics::Chapter{"The running daemon", diagnostics::running},
};

[[nodiscard]] consteval const diagnostics::Kind& kind(std::string_view name) {
  return diagnostics::kind(name, all_chapters);
}

}  // namespace odomd::tools
