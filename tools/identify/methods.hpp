// The methods of odom identify: each file adds its own subcommand.
#pragma once

#include "tools/cli/command.hpp"

namespace odomd::tools {

// In the order of use: on the scale, on the cords, at rest, on circles, on a lap.
void add_mass(Command identify);
void add_cog(Command identify);
void add_inertia(Command identify);
void add_noise(Command identify);
void add_track(Command identify);
void add_stiffness(Command identify);
void add_latency(Command identify);
void add_fit(Command identify);

}  // namespace odomd::tools
