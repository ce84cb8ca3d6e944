#include "tools/diagnostics/log_order.hpp"

#include <fmt/format.h>

#include <stdexcept>

namespace odomd::tools {

void LogOrder::require_sorted() const {
  if (late_ == 0) return;
  throw std::invalid_argument(fmt::format(
      "{}{} stamped a second or more before frames ahead of {}; sort the log, or cut it where its "
      "clock was set back",
      first_late_,
      late_ == 1 ? std::string("this frame is") : fmt::format("from here on {} frames are", late_),
      late_ == 1 ? "it" : "them"));
}

}  // namespace odomd::tools
