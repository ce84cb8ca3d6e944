// How often the process has taken memory from the heap by operator new.
#pragma once

#include <cstddef>

namespace odomd::estimator::testing {

[[nodiscard]] std::size_t allocations() noexcept;

}  // namespace odomd::estimator::testing
