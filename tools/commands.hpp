// The subcommands of odom. Each file adds its own to the command line; parsing runs it.
//
// A command reports unusable input by throwing std::invalid_argument (exit status 2) and work that
// failed by any other std::exception (exit status 1); the text is the one line that the user reads.
#pragma once

#include <CLI/CLI.hpp>

namespace odomd::tools {

/// The whole command line of odom: every subcommand below.
void describe(CLI::App& odom);

void add_bridge(CLI::App& odom);
void add_export(CLI::App& odom);
void add_help(CLI::App& odom);
void add_identify(CLI::App& odom);
void add_record(CLI::App& odom);
void add_replay(CLI::App& odom);
void add_evaluate(CLI::App& odom);
void add_plot(CLI::App& odom);
void add_status(CLI::App& odom);
void add_pose(CLI::App& odom);
void add_camera(CLI::App& odom);
void add_sim(CLI::App& odom);
void add_tune(CLI::App& odom);
void add_watch(CLI::App& odom);
void add_dbc(CLI::App& odom);

}  // namespace odomd::tools
