// All kinds of diagnostics: those of the daemon, and of experiments and machines, which only tools
// examine. docs/diagnostics.md is generated from them.
#pragma once

#include "daemon/diagnostics/diagnostic.hpp"
#include "tools/diagnostics/identification.hpp"
#include "tools/diagnostics/machine.hpp"

namespace odomd::tools {

/// In the order of the codes.
inline constexpr std::array all_chapters{
    diagnostics::chapters[0],
    diagnostics::chapters[1],
    diagnostics::chapters[2],
    diagnostics::chapters[3],
    diagnostics::Chapter{"Identification", diagnostics::identification},
    diagnostics::Chapter{"The machine", diagnostics::machine},
    diagnostics::chapters[4],
    diagnostics::chapters[5],
};

[[nodiscard]] consteval const diagnostics::Kind& kind(std::string_view name) {
  return diagnostics::kind(name, all_chapters);
}

}  // namespace odomd::tools
