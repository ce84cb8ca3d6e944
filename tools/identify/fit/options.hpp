// The command line of odom identify fit, for `odom`, which describes and checks it, and for the
// program odom-fit, the only one linked with Ceres.
#pragma once

#include <string>
#include <vector>

#include "tools/cli/command.hpp"
#include "tools/identify/common/finding.hpp"
#include "tools/replay/log_options.hpp"

namespace odomd::tools {

struct FitOptions {
  std::string config;               ///< empty: the drives' own
  std::vector<std::string> drives;  ///< folders
  std::vector<std::string> dbc;
  bool use_reference = false;
  std::vector<std::string> fixed;
  std::vector<std::string> freed;
  std::vector<std::string> priors;
  double from = 0.0;
  double to = 0.0;
  int threads = 1;
  bool untried = false;
  bool quiet = false;
  Delivery delivery;
  can::Damage damage = can::Damage::left_out;
};

/// Adds the options, the description and the examples.
void describe_fit(Command command, FitOptions& options);

/// Checks options that depend on each other. Throws std::invalid_argument.
void check(const FitOptions& options);

}  // namespace odomd::tools
