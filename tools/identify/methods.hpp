// The methods of odom identify: each file adds its own subcommand.
#pragma once

#include <CLI/CLI.hpp>

namespace odomd::tools {

// In the order of an afternoon: on the scale, on the cords, standing, on the circle, on a lap.
void add_mass(CLI::App& identify);
void add_cog(CLI::App& identify);
void add_inertia(CLI::App& identify);
void add_noise(CLI::App& identify);
void add_track(CLI::App& identify);
void add_stiffness(CLI::App& identify);
void add_latency(CLI::App& identify);
void add_fit(CLI::App& identify);

}  // namespace odomd::tools
