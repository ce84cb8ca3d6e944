// Events from the beat to housekeeping: of a small fixed size, through a ring with one producer and
// one consumer. push() costs a few stores; a full ring drops the event and counts it.
#pragma once

#include <cstdint>
#include <optional>

#include "base/counter.hpp"
#include "base/spsc_ring.hpp"

namespace odomd::daemon {

enum class EventKind : std::uint8_t {
  overrun,        ///< a: execution time of the tick [ns], b: its wake-up latency [ns]
  missed,         ///< a: cycles skipped, b: wake-up latency of the tick [ns]
  pose_reset,     ///< a: the reset count
  clock_stepped,  ///< a: step of CLOCK_REALTIME [ns]
  suspended,      ///< a: how long the machine was suspended [ns]
  camera_gone,
  camera_malformed  ///< a: a MalformedCause
};

struct Event {
  EventKind kind = EventKind::overrun;
  std::int64_t a = 0;
  std::int64_t b = 0;
};

class EventRing {
 public:
  /// The beat's call.
  void push(const Event& event) noexcept {
    if (!ring_.push(event)) dropped_.add();
  }

  /// Called by housekeeping: the oldest event, if any.
  [[nodiscard]] std::optional<Event> next() noexcept {
    const Event* front = ring_.front();
    if (front == nullptr) return std::nullopt;
    const Event event = *front;
    ring_.pop();
    return event;
  }

  /// Events that found the ring full. Any thread.
  [[nodiscard]] std::uint64_t dropped() const noexcept { return dropped_.get(); }

 private:
  SpscRing<Event, 256> ring_;
  Counter dropped_;
};

}  // namespace odomd::daemon
