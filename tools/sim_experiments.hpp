// The subcommands of odom sim that are no drives.
#pragma once

#include <CLI/CLI.hpp>

namespace odomd::tools {

void add_sim_experiments(CLI::App& sim);

}  // namespace odomd::tools
