#include "tools/diagnostics/log_order.hpp"

#include <fmt/format.h>

#include <stdexcept>

namespace odomd::tools {

void LogOrder::require_sorted() const {
  if (late_ == 0) return;
  throw std::invalid_argument(fmt::format(
      "{}{}; sort the log (tac turns one in reverse), or cut it where its clock was set back",
      first_late_,
      late_ == 1 ? std::string("this frame has a stamp a second or more earlier than one before it")
                 : fmt::format("from here on {} frames have stamps a second or more earlier than "
                               "frames before them",
                               late_)));
}

}  // namespace odomd::tools
