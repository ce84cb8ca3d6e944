// A ring between two threads: one pushes, one pops. No lock, no allocation after construction.
#pragma once

#include <array>
#include <atomic>
#include <cstddef>
#include <type_traits>

namespace odomd {

/// Wait-free on both sides. Exactly one thread calls `push`, exactly one calls `front` and `pop`;
/// any thread may call `empty`. Large: keep it on the heap.
template <typename T, std::size_t capacity>
class SpscRing {  // NOLINT(clang-analyzer-optin.performance.Padding): a cache line for each side
  static_assert(capacity > 0 && (capacity & (capacity - 1)) == 0, "a power of two");
  static_assert(std::is_trivially_copyable_v<T>);

 public:
  SpscRing() = default;
  SpscRing(const SpscRing&) = delete;
  SpscRing& operator=(const SpscRing&) = delete;
  ~SpscRing() = default;

  /// Returns false, and overwrites nothing, when the ring is full.
  bool push(const T& value) noexcept {
    const std::size_t tail = tail_.load(std::memory_order_relaxed);
    if (tail - seen_head_ == capacity) {
      // Pairs with the release in pop: the consumer has finished reading the element to overwrite.
      seen_head_ = head_.load(std::memory_order_acquire);
      if (tail - seen_head_ == capacity) return false;
    }
    items_[tail % capacity] = value;
    tail_.store(tail + 1, std::memory_order_release);
    return true;
  }

  /// The oldest element, or null when the ring is empty. Valid until pop.
  [[nodiscard]] const T* front() noexcept {
    const std::size_t head = head_.load(std::memory_order_relaxed);
    if (head == seen_tail_) {
      // Pairs with the release in push: what was written before the tail moved is visible.
      seen_tail_ = tail_.load(std::memory_order_acquire);
      if (head == seen_tail_) return nullptr;
    }
    return &items_[head % capacity];
  }

  /// Call only after front() returned an element.
  void pop() noexcept {
    head_.store(head_.load(std::memory_order_relaxed) + 1, std::memory_order_release);
  }

  [[nodiscard]] bool empty() const noexcept {
    return head_.load(std::memory_order_acquire) == tail_.load(std::memory_order_acquire);
  }

 private:
  static constexpr std::size_t cache_line = 64;

  std::array<T, capacity> items_{};
  alignas(cache_line) std::atomic<std::size_t> tail_{0};  // written by the producer
  std::size_t seen_head_ = 0;                             // the producer's copy of head_
  alignas(cache_line) std::atomic<std::size_t> head_{0};  // written by the consumer
  std::size_t seen_tail_ = 0;                             // the consumer's copy of tail_
};

}  // namespace odomd
