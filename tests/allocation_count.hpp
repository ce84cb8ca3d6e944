// Number of heap allocations of a test program. Programs that count are linked with
// allocation_count.cpp, which replaces their operator new.
#pragma once

#include <cstddef>

namespace odomd {

/// Calls of operator new in all threads since the start.
[[nodiscard]] std::size_t allocation_count() noexcept;

}  // namespace odomd
