// One fault: what fails, when, and by how much.
#pragma once

#include <cmath>
#include <cstdint>
#include <limits>
#include <string_view>

#include "tools/fault/kinds.hpp"

namespace odomd::fault {

struct Fault {
  Kind kind;
  double begin_s = 0.0;                                         ///< after the first frame
  double duration_s = std::numeric_limits<double>::infinity();  ///< infinite: to the end
  double magnitude = 0.0;                                       ///< see default_magnitude()
  std::uint64_t seed = 1;                                       ///< seed of its random parts
};

/// A fault with the kind's default size, from the first frame to the end.
[[nodiscard]] Fault fault_of(Kind kind);

/// "KIND[:BEGIN[:LENGTH[:SIZE]]]", times in seconds; omitted or empty parts are as in fault_of().
/// Throws std::invalid_argument that names the wrong part.
[[nodiscard]] Fault parse_fault(std::string_view text);

/// Throws std::invalid_argument for a time or a size that the kind cannot have.
void check(const Fault& fault);

/// When a fault acts, in the drive's own time: from begin_ns on, before end_ns.
struct Span {
  std::int64_t begin_ns = 0;
  std::int64_t end_ns = 0;

  [[nodiscard]] bool holds(std::int64_t time_ns) const noexcept {
    return begin_ns <= time_ns && time_ns < end_ns;
  }
};

/// `start_ns`: the stamp of the drive's first frame.
[[nodiscard]] inline Span span_of(const Fault& fault, std::int64_t start_ns) noexcept {
  constexpr double longest_s = 1e9;
  const std::int64_t begin_ns = start_ns + std::llround(fault.begin_s * 1e9);
  const bool ends = fault.duration_s < longest_s;
  return {begin_ns, ends ? begin_ns + std::llround(fault.duration_s * 1e9)
                         : std::numeric_limits<std::int64_t>::max()};
}

}  // namespace odomd::fault
