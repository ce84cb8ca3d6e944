// The methods of odom identify: each file adds its own subcommand.
#pragma once

#include "tools/cli/command.hpp"

namespace odomd::tools {

// In the order of an afternoon: on the scale, on the cords, standing, on the circle, on a lap.
void add_mass(Command identify);
void add_cog(Command identify);
void add_inertia(Command identify);
void add_noise(Command identify);
void add_track(Command identify);
void add_stiffness(Command identify);
void add_latency(Command identify);
void add_fit(Command identify);

}  // namespace odomd::tools
