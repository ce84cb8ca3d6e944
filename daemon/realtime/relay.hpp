// The thread that wakes the readers. The beat wakes only this thread, with one futex call, so the
// number of readers does not affect the beat.
#pragma once

#include <atomic>
#include <cstdint>
#include <functional>
#include <thread>

#include "daemon/realtime/privileges.hpp"

namespace odomd::daemon {

class Relay {
 public:
  /// `wake_all` runs in the relay's thread, once for all calls of ring() since its last run.
  /// `priority` is that of the beat; the relay runs one below.
  Relay(int priority, int cpu, std::function<void()> wake_all);
  ~Relay();
  Relay(const Relay&) = delete;
  Relay& operator=(const Relay&) = delete;

  /// Called by the beat, once a tick: one store and one FUTEX_WAKE of one thread.
  void ring() noexcept;

  /// The privileges of the thread; known when the constructor has returned.
  [[nodiscard]] const ThreadGrant& grant() const noexcept { return grant_; }

 private:
  void run(int priority, int cpu);

  std::function<void()> wake_all_;
  std::atomic<std::uint32_t> rings_{0};
  std::atomic<bool> stop_{false};
  std::atomic<bool> started_{false};
  ThreadGrant grant_;
  std::thread thread_;
};

}  // namespace odomd::daemon
