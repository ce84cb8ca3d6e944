// What a flag of a source says, in words: the daemon's as it runs, and those who replay a drive.
#pragma once

#include <string_view>

#include "estimator/integrity/source_monitor.hpp"

namespace odomd::daemon {

/// Goes on behind the source's name.
[[nodiscard]] constexpr std::string_view complaint(estimator::SourceFlag flag) noexcept {
  using estimator::SourceFlag;
  switch (flag) {
    case SourceFlag::out_of_range:
      return " is out of range: no car does that; look at its scale and wiring";
    case SourceFlag::non_finite:
      return " is no number";
    case SourceFlag::frozen:
      return " is frozen: it repeats one value while the car moves on";
    case SourceFlag::drifting:
      return " contradicts the other sensors: look at its scale, offset and mounting";
    default:
      return " fails its protection: look at the status";
  }
}

}  // namespace odomd::daemon
