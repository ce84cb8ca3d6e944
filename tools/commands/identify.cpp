// odom identify: measures the car's parameters and their uncertainty.
#include "tools/commands/commands.hpp"
#include "tools/identify/common/finding.hpp"

namespace odomd::tools {

void add_identify(Command odom) {
  Command identify = odom.add_subcommand(
      "identify",
      "Measure the car's parameters with their uncertainties and write them to the configuration");
  identify.require_subcommand();
  identify.footer(
      "Order: mass, cog, inertia, noise, track and stiffness, latency, fit. Measure at least\n"
      "mass and cog by hand; fit then finds the rest from one drive with camera poses or a\n"
      "reference. The other methods measure single properties, and are needed only if there\n"
      "is no such drive.\n\n"
      "The help of each method explains its experiment: what to do, what to measure and how\n"
      "precisely. With --write, the numbers replace those in the configuration, each with a\n"
      "note on its origin; other comments are kept.\n\n"
      "Examples:\n"
      "  odom identify mass --help\n"
      "  odom identify mass --total 2985g --scale-resolution 1g --write car.toml");
  add_mass(identify);
  add_cog(identify);
  add_inertia(identify);
  add_noise(identify);
  add_track(identify);
  add_stiffness(identify);
  add_latency(identify);
  add_fit(identify);
}

}  // namespace odomd::tools
