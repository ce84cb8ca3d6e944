// odom identify: the car's parameters, measured, with their uncertainty.
#include "tools/commands.hpp"
#include "tools/identify/methods.hpp"

namespace odomd::tools {

void add_identify(CLI::App& odom) {
  CLI::App* identify = odom.add_subcommand(
      "identify",
      "Measure the car's parameters, each with its uncertainty, into the configuration");
  identify->require_subcommand(1);
  identify->footer(
      "Each method explains its experiment: odom identify mass --help. An afternoon's guide is "
      "docs/identify.md.");
}

}  // namespace odomd::tools
