#include "tools/replay/log_options.hpp"

#include <CLI/CLI.hpp>

namespace odomd::tools {

void add_strict(Command command, can::Damage& damage) {
  command.app().add_flag_callback(
      "--strict", [&damage] { damage = can::Damage::refused; },
      "Refuse a log with damaged lines instead of leaving them out");
}

}  // namespace odomd::tools
