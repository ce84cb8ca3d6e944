// The subcommands of odom, and the headers that most of them need. Each file adds its own to the
// command line; parsing runs it.
//
// A command reports unusable input by throwing std::invalid_argument (exit status 2) and failed
// work by any other std::exception (exit status 1); its text is the line that the user reads.
#pragma once

#include <fmt/format.h>

#include <algorithm>
#include <chrono>
#include <filesystem>
#include <iostream>
#include <memory>
#include <nlohmann/json.hpp>
#include <optional>
#include <stdexcept>
#include <string>
#include <utility>
#include <vector>

#include "tools/cli/command_line.hpp"
#include "tools/cli/files.hpp"
#include "tools/cli/output.hpp"
#include "tools/cli/text.hpp"

namespace odomd::tools {

/// The whole command line of odom: every subcommand below.
void describe(Command odom);

void add_bridge(Command odom);
void add_doctor(Command odom);
void add_export(Command odom);
void add_fault(Command odom);
void add_identify(Command odom);
void add_import(Command odom);
void add_init(Command odom);
void add_record(Command odom);
void add_replay(Command odom);
void add_evaluate(Command odom);
void add_plot(Command odom);
void add_status(Command odom);
void add_pose(Command odom);
void add_camera(Command odom);
void add_serve(Command odom);
void add_sim(Command odom);
void add_sim_experiments(Command sim);  ///< its subcommands
void add_watch(Command odom);
void add_dbc(Command odom);

}  // namespace odomd::tools
