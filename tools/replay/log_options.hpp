// The options of all commands that read logs.
#pragma once

#include "can_protocol/sources/log_reader.hpp"
#include "tools/cli/command.hpp"

namespace odomd::tools {

/// Adds --strict, the last of a command's options.
inline void add_strict(Command command, can::Damage& damage) {
  command.add_flag("--strict", damage, can::Damage::refused,
                   "Refuse a log with damaged lines instead of leaving them out");
}

}  // namespace odomd::tools
