#include "daemon/realtime/relay.hpp"

#include <linux/futex.h>
#include <sys/syscall.h>
#include <unistd.h>

#include <utility>

namespace odomd::daemon {
namespace {

static_assert(std::atomic<std::uint32_t>::is_always_lock_free);

void futex(std::atomic<std::uint32_t>& word, int operation, std::uint32_t value) noexcept {
  ::syscall(SYS_futex, &word, operation, value, nullptr, nullptr, 0);
}

}  // namespace

Relay::Relay(int priority, int cpu, std::function<void()> wake_all)
    : wake_all_(std::move(wake_all)), thread_([this, priority, cpu] { run(priority - 1, cpu); }) {
  started_.wait(false, std::memory_order_acquire);
}

Relay::~Relay() {
  stop_.store(true, std::memory_order_relaxed);
  ring();
  thread_.join();
}

void Relay::ring() noexcept {
  rings_.fetch_add(1, std::memory_order_release);
  futex(rings_, FUTEX_WAKE_PRIVATE, 1);
}

void Relay::run(int priority, int cpu) {
  grant_ = become_realtime(priority, cpu, "odomd-relay");
  started_.store(true, std::memory_order_release);
  started_.notify_one();
  std::uint32_t seen = 0;
  while (!stop_.load(std::memory_order_relaxed)) {
    const std::uint32_t rings = rings_.load(std::memory_order_acquire);
    if (rings == seen) {
      // Sleeps only while the word is unchanged, so a call of ring() in between is not lost.
      futex(rings_, FUTEX_WAIT_PRIVATE, seen);
      continue;
    }
    seen = rings;
    wake_all_();
  }
}

}  // namespace odomd::daemon
