// Replaces operator new of the test program. In a file of its own, so that no compiler sees through
// it at the call and complains that new is freed by free.
#include "allocations.hpp"

#include <atomic>
#include <cstdlib>
#include <new>

namespace {
std::atomic<std::size_t> count{0};
}  // namespace

namespace odomd::estimator::testing {
std::size_t allocations() noexcept {
  return count;
}
}  // namespace odomd::estimator::testing

void* operator new(std::size_t size) {
  ++count;
  if (void* memory = std::malloc(size)) {
    return memory;
  }
  throw std::bad_alloc{};
}
void operator delete(void* memory) noexcept {
  std::free(memory);
}
void operator delete(void* memory, std::size_t) noexcept {
  std::free(memory);
}
