#include "daemon/realtime/beat.hpp"

#include <ctime>

#include <cerrno>

#include "base/wall_clock.hpp"
#include "daemon/core/pipeline.hpp"
#include "daemon/core/recording_tap.hpp"

namespace odomd::daemon {
namespace {

void sleep_until(std::int64_t monotonic_ns) noexcept {
  const timespec wake{monotonic_ns / 1'000'000'000, monotonic_ns % 1'000'000'000};
  while (::clock_nanosleep(CLOCK_MONOTONIC, TIMER_ABSTIME, &wake, nullptr) == EINTR) {
  }
}

}  // namespace

Beat::Beat(const BeatParts& parts, std::int64_t period_ns) : parts_(parts), grid_{0, period_ns} {}

void Beat::run(const Surroundings& surroundings) noexcept {
  surroundings_ = surroundings;
  grid_ = grid_from(monotonic_now(), grid_.period_ns);
  parts_.writer.set_first_tick(grid_.first_ns);

  for (std::uint64_t planned = 1; !stop_.load(std::memory_order_relaxed);) {
    sleep_until(grid_.time_of(planned));
    const std::int64_t woke_ns = monotonic_now();
    const std::int64_t wakeup_latency_ns = woke_ns - grid_.time_of(planned);
    const NextTick due = due_tick(grid_, planned, woke_ns);
    const std::int64_t tick_ns = grid_.time_of(due.tick);

    read_clock(woke_ns);
    drain_buses(tick_ns, woke_ns);
    drain_cameras(woke_ns);
    const std::uint32_t conditions = surroundings_.conditions(seen_);
    parts_.pipeline.set_conditions(conditions);
    const TickRecord& record = parts_.pipeline.tick(due.tick, tick_ns);
    publish(record, wakeup_latency_ns);
    parts_.relay.ring();
    parts_.tap.tick_done(record, {woke_ns, wall_clock_.offset_ns(), conditions}, parts_.pipeline);
    planned = account(due, wakeup_latency_ns, woke_ns);
  }
}

void Beat::read_clock(std::int64_t now_ns) noexcept {
  const auto before_ns = static_cast<std::int64_t>(counters_.realtime_offset_ns.get());
  const ClockEvent event = wall_clock_.update(read_clocks());
  const std::int64_t offset_ns = wall_clock_.offset_ns();
  counters_.realtime_offset_ns.set(static_cast<std::uint64_t>(offset_ns));
  parts_.writer.set_realtime_offset(offset_ns);
  if (const auto log_offset_ns = parts_.log_clock.offset_ns())
    parts_.writer.set_log_offset(*log_offset_ns);

  seen_ = {.now_ns = now_ns,
           .clock_stepped = event == ClockEvent::stepped,
           .suspended = event == ClockEvent::suspended};
  if (event == ClockEvent::none) return;
  (seen_.suspended ? counters_.suspends : counters_.clock_steps).add();
  parts_.events.push({seen_.suspended ? EventKind::suspended : EventKind::clock_stepped,
                      offset_ns - before_ns, 0});
}

void Beat::drain_buses(std::int64_t tick_ns, std::int64_t now_ns) noexcept {
  for (const auto& source : parts_.sources) {
    const can::SourceCounters& counters = source->counters();
    const std::uint64_t carried_over = counters.carried_over.get();
    const std::size_t count = source->drain(frames_, tick_ns, now_ns);
    for (std::size_t i = 0; i < count; ++i) {
      parts_.pipeline.take(frames_[i], now_ns);
      parts_.tap.take(frames_[i]);
    }

    if (counters.carried_over.get() != carried_over) {
      seen_.carried_over = true;
      parts_.writer.count_carried_over();
    }
    seen_.frames_lost += counters.lost.get();
    const can::LinkState link = source->link();
    seen_.link_down |= link == can::LinkState::down || link == can::LinkState::gone;
    seen_.input_ended |= link == can::LinkState::ended;
  }
}

void Beat::drain_cameras(std::int64_t now_ns) noexcept {
  const MessageClocks clocks{wall_clock_, parts_.log_clock.offset_ns()};
  const auto drained = parts_.cameras.drain(poses_, clocks, now_ns, parts_.events);
  for (std::size_t i = 0; i < drained.poses; ++i) {
    parts_.pipeline.take(poses_[i]);
    parts_.tap.take(poses_[i]);
  }
  for (std::size_t i = 0; i < drained.malformed; ++i)
    parts_.pipeline.take_malformed_camera_message();
  seen_.cameras_refused = parts_.cameras.refused();
  counters_.camera_messages.add(drained.poses + drained.malformed);
  counters_.camera_malformed.add(drained.malformed);
}

void Beat::publish(const TickRecord& record, std::int64_t wakeup_latency_ns) noexcept {
  const odom_pose& pose = record.pose;
  odom_details details = record.details;
  details.wakeup_latency_ns = wakeup_latency_ns;
  details.execution_ns = execution_ns_;
  parts_.writer.publish(pose, details);

  if (pose.reset_count != reset_count_)
    parts_.events.push({EventKind::pose_reset, pose.reset_count, 0});
  reset_count_ = pose.reset_count;
}

std::uint64_t Beat::account(const NextTick& due, std::int64_t wakeup_latency_ns,
                            std::int64_t woke_ns) noexcept {
  shm::Writer& writer = parts_.writer;
  const std::int64_t done_ns = monotonic_now();
  execution_ns_ = done_ns - woke_ns;
  writer.set_heartbeat(done_ns);
  writer.count_wakeup(wakeup_latency_ns);
  writer.count_execution(execution_ns_);
  counters_.ticks.add();

  const NextTick next = next_tick(grid_, due.tick, done_ns);
  if (next.missed > 0) {
    writer.count_overrun(done_ns, execution_ns_);
    parts_.events.push({EventKind::overrun, execution_ns_, wakeup_latency_ns});
  }
  // Counted with the next tick, so that ticks plus missed cycles equal the newest tick number.
  if (const std::uint64_t missed = skipped_ + due.missed; missed > 0) {
    writer.count_missed(missed);
    parts_.events.push({EventKind::missed, static_cast<std::int64_t>(missed), wakeup_latency_ns});
  }
  skipped_ = next.missed;
  return next.tick;
}

}  // namespace odomd::daemon
