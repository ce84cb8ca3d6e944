// Counts the heap allocations of a test binary, whose operator new allocation_count.cpp replaces.
#pragma once

#include <cstddef>

namespace odomd::can {

/// By operator new, of all threads, since the start.
[[nodiscard]] std::size_t allocation_count() noexcept;

}  // namespace odomd::can
