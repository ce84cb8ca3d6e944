// The methods of odom identify: each file adds its own subcommand.
#pragma once

#include <memory>
#include <string>

#include "tools/cli/command.hpp"
#include "tools/cli/command_line.hpp"

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

/// Adds a method that is a program of its own, which alone is linked with a large library. Without
/// it `missing` says what to install.
template <class Options>
void add_program(Command identify, const std::string& name, void (*describe)(Command, Options&),
                 const std::string& missing) {
  const auto options = std::make_shared<Options>();
  const Command method = identify.add_subcommand(name);
  describe(method, *options);
  method.callback([=] {
    check(*options);
    become("odom-" + name, method.given(), missing);
  });
}

}  // namespace odomd::tools
