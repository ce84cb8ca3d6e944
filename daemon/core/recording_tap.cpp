#include "daemon/core/recording_tap.hpp"

#include <algorithm>
#include <memory>

namespace odomd::daemon {

void RecordingTap::tick_done(const TickRecord& record, const Around& around,
                             const Pipeline& pipeline) noexcept {
  // Acquire: a beat that sees the request sees the rings that housekeeping created and emptied.
  const State state = state_.load(std::memory_order_acquire);
  if (state == State::idle || state == State::full) return;
  if (state == State::unwanted) {
    taking_ = false;
    state_.store(State::idle, std::memory_order_release);
    return;
  }
  if (state == State::wanted) {
    // In place: assigning a filter would put a copy on the stack, 0.9 MB of the beat's 1 MB.
    std::construct_at(&checkpoint_.state, pipeline.state());
    std::ranges::copy(pipeline.protections(), checkpoint_.protections.begin());
    mark_ = {};
    taking_ = true;
  }

  mark_.record = record;
  mark_.woke_ns = around.woke_ns;
  mark_.realtime_offset_ns = around.realtime_offset_ns;
  mark_.conditions = around.conditions;
  taking_ = taking_ && rings_->marks.push(mark_);
  mark_.frames = 0;
  mark_.cameras = 0;

  // Housekeeping may have withdrawn the request meanwhile; then the withdrawal takes precedence.
  State expected = state;
  const State next = taking_ ? State::running : State::full;
  if (next != state)
    state_.compare_exchange_strong(expected, next, std::memory_order_release,
                                   std::memory_order_relaxed);
}

void RecordingTap::begin() {
  // The beat is idle and does not touch the rings: clear what an earlier recording left.
  if (!rings_) rings_ = std::make_unique<Rings>();
  while (rings_->frames.front() != nullptr) rings_->frames.pop();
  while (rings_->cameras.front() != nullptr) rings_->cameras.pop();
  while (rings_->marks.front() != nullptr) rings_->marks.pop();
  state_.store(State::wanted, std::memory_order_release);
}

void RecordingTap::end() noexcept {
  if (state() != State::idle) state_.store(State::unwanted, std::memory_order_release);
}

}  // namespace odomd::daemon
