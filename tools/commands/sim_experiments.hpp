// The subcommands of odom sim that are no drives.
#pragma once

#include "tools/cli/command.hpp"

namespace odomd::tools {

void add_sim_experiments(Command sim);

}  // namespace odomd::tools
