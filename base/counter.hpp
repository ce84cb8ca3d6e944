// A counter that one thread increments and any thread may read, without a locked instruction.
#pragma once

#include <atomic>
#include <cstdint>

namespace odomd {

/// Wait-free. Exactly one thread may call `add` and `set`; any thread may call `get`. The memory
/// order is relaxed: a reader gets a recent value, but no guarantee about other memory.
class Counter {
 public:
  Counter() = default;
  Counter(const Counter& other) : value_(other.get()) {}
  Counter& operator=(const Counter& other) {  // NOLINT(cert-oop54-cpp): self-assignment works
    set(other.get());
    return *this;
  }
  ~Counter() = default;

  void add(std::uint64_t n = 1) noexcept { set(get() + n); }
  void set(std::uint64_t n) noexcept { value_.store(n, std::memory_order_relaxed); }
  [[nodiscard]] std::uint64_t get() const noexcept {
    return value_.load(std::memory_order_relaxed);
  }

 private:
  std::atomic<std::uint64_t> value_{0};
};

}  // namespace odomd
