// A separate file: a compiler that sees this operator new at a call would report that free()
// releases memory from new.
#include "tests/allocation_count.hpp"

#include <atomic>
#include <cstdlib>
#include <new>

namespace {
std::atomic<std::size_t> count{0};
}  // namespace

namespace odomd {
std::size_t allocation_count() noexcept {
  return count.load();
}
}  // namespace odomd

#if defined(__has_feature)
#if __has_feature(thread_sanitizer)
#define ODOMD_SANITIZER_OWNS_NEW
#endif
#endif

#ifdef ODOMD_SANITIZER_OWNS_NEW
// The sanitizer's own operator new calls this at each allocation.
extern "C" void __sanitizer_malloc_hook(const volatile void*, std::size_t) {
  ++count;
}
#else
void* operator new(std::size_t size) {
  ++count;
  if (void* memory = std::malloc(size == 0 ? 1 : size)) return memory;
  throw std::bad_alloc();
}
// std::stable_sort() and others allocate with this operator, and release with the plain delete.
void* operator new(std::size_t size, const std::nothrow_t&) noexcept {
  ++count;
  return std::malloc(size == 0 ? 1 : size);
}
void operator delete(void* memory) noexcept {
  std::free(memory);
}
void operator delete(void* memory, std::size_t) noexcept {
  std::free(memory);
}
#endif
