// Times are whole nanoseconds; seconds are for arithmetic and for people.
#pragma once

#include <cstdint>

namespace odomd {

inline constexpr std::int64_t ns_per_s = 1'000'000'000;

[[nodiscard]] constexpr double seconds(std::int64_t ns) noexcept {
  return static_cast<double>(ns) * 1e-9;
}

}  // namespace odomd
