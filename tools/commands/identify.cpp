// odom identify: measures the car's parameters and their uncertainty.
#include "tools/commands/commands.hpp"
#include "tools/identify/methods.hpp"

namespace odomd::tools {

void add_identify(Command odom) {
  Command identify = odom.add_subcommand(
      "identify",
      "Measure the car's parameters with their uncertainties and write them to the configuration");
  identify.require_subcommand();
  identify.footer(
      "Order: mass, cog, inertia, noise, track and stiffness, latency, fit. At least measure mass\n"
      "and cog by hand; then fit finds the rest on one drive with camera poses or a reference. "
      "The\n"
      "other methods measure a value on its own, and are needed where there is no such drive.\n"
      "\n"
      "Each method explains its experiment: what to do, what to measure and how precisely. With\n"
      "--write the numbers replace those in the configuration, each with a note on its origin;\n"
      "other comments stay.\n"
      "\n"
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
