#include "tools/replay/log_options.hpp"

namespace odomd::tools {

void add_strict(Command command, can::Damage& damage) {
  command.add_flag("--strict", damage, can::Damage::refused,
                   "Refuse a log with damaged lines instead of leaving them out");
}

}  // namespace odomd::tools
