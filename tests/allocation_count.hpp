// How often a test program has taken memory from the heap. allocation_count.cpp goes into programs
// that count, and replaces their operator new.
#pragma once

#include <cstddef>

namespace odomd {

/// By operator new, of all threads, since the start.
[[nodiscard]] std::size_t allocation_count() noexcept;

}  // namespace odomd
