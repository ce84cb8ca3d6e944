// The options of all commands that read logs.
#pragma once

#include "can_protocol/sources/log_reader.hpp"
#include "tools/cli/command.hpp"

namespace odomd::tools {

/// Adds --strict, the last of a command's options.
void add_strict(Command command, can::Damage& damage);

}  // namespace odomd::tools
