// An error in a configuration, as the one line that the user reads.
#pragma once

#include <stdexcept>

namespace odomd::daemon {

/// "car.toml:12: [vehicle] mas: unknown key; did you mean \"mass\"?"
class ConfigError : public std::invalid_argument {
 public:
  using std::invalid_argument::invalid_argument;
};

}  // namespace odomd::daemon
