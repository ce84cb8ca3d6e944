// The subcommands of odom sim other than drives.
#pragma once

#include "tools/cli/command.hpp"

namespace odomd::tools {

void add_sim_experiments(Command sim);

}  // namespace odomd::tools
