// Watches which sources are alive: when each was last received, how old its newest sample is, and
// whether it is overdue. Pure logic on given times, all on the pipeline's clock.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>

#include <algorithm>

#include "estimator/common/measurement.hpp"

namespace odomd::daemon {

class SourceWatch {
 public:
  /// Adds a configured source; it is overdue when nothing was received for longer than the
  /// time-out.
  void configure(std::size_t source, std::int64_t timeout_ns) noexcept {
    entries_[source].configured = true;
    entries_[source].timeout_ns = timeout_ns;
  }

  /// A sample taken at `taken_ns` was received at `heard_ns`.
  void heard(std::size_t source, std::int64_t heard_ns, std::int64_t taken_ns) noexcept {
    Entry& entry = entries_[source];
    entry.seen = true;
    entry.failing = false;
    entry.heard_ns = heard_ns;
    entry.taken_ns = taken_ns;
  }

  /// A frame of the source failed its protection.
  void failed(std::size_t source) noexcept { entries_[source].failing = true; }

  /// Age of the newest sample [ns]; -1: never seen.
  [[nodiscard]] std::int64_t age_ns(std::size_t source, std::int64_t now_ns) const noexcept {
    return entries_[source].seen ? now_ns - entries_[source].taken_ns : -1;
  }

  /// Whether a configured source was silent beyond its time-out. For a source that was never
  /// received the time-out starts at `start_ns`.
  [[nodiscard]] bool overdue(std::size_t source, std::int64_t now_ns,
                             std::int64_t start_ns) const noexcept {
    const Entry& entry = entries_[source];
    const std::int64_t since = entry.seen ? entry.heard_ns : start_ns;
    return entry.configured && now_ns - since > entry.timeout_ns;
  }

  /// A sample that every filter rejects: two in a row raise a flag.
  void refused(std::size_t source, estimator::Verdict verdict, std::int64_t now_ns) noexcept {
    Entry& entry = entries_[source];
    entry.bad = std::min(entry.bad + 1, bad_in_a_row);
    if (entry.bad == bad_in_a_row) {
      entry.flag = verdict == estimator::Verdict::gated ? estimator::SourceFlag::out_of_range
                                                        : estimator::SourceFlag::non_finite;
      entry.bad_ns = now_ns;
    }
  }
  void usable(std::size_t source) noexcept { entries_[source].bad = 0; }

  /// A camera message that is not a pose: a usable pose before or after it in the same tick takes
  /// precedence.
  void unusable_pose() noexcept { ++unusable_poses_; }
  void usable_pose() noexcept { usable_pose_ = true; }

  /// Call once per tick: a flag clears when nothing was refused for a second.
  void settle(std::int64_t tick_ns) noexcept {
    constexpr std::int64_t calm_ns = 1'000'000'000;
    constexpr auto camera = static_cast<std::size_t>(estimator::Source::camera);
    if (usable_pose_) {
      usable(camera);
    } else {
      for (int i = std::min(unusable_poses_, bad_in_a_row); i > 0; --i) {
        refused(camera, estimator::Verdict::non_finite, tick_ns);
      }
    }
    unusable_poses_ = 0;
    usable_pose_ = false;
    for (Entry& entry : entries_) {
      if (tick_ns - entry.bad_ns >= calm_ns) entry.flag = estimator::SourceFlag::ok;
    }
  }

  /// out_of_range, non_finite or ok.
  [[nodiscard]] estimator::SourceFlag flag(std::size_t source) const noexcept {
    return entries_[source].flag;
  }

  [[nodiscard]] bool failing(std::size_t source) const noexcept { return entries_[source].failing; }

  [[nodiscard]] bool healthy(std::size_t source, std::int64_t now_ns) const noexcept {
    const Entry& entry = entries_[source];
    return entry.configured && entry.seen && !entry.failing && !overdue(source, now_ns, now_ns);
  }

 private:
  struct Entry {
    bool configured = false;
    bool seen = false;
    bool failing = false;
    int bad = 0;  ///< samples in a row that were refused
    estimator::SourceFlag flag = estimator::SourceFlag::ok;
    std::int64_t bad_ns = 0;
    std::int64_t timeout_ns = 0;
    std::int64_t heard_ns = 0;
    std::int64_t taken_ns = 0;
  };
  static constexpr int bad_in_a_row = 2;

  std::array<Entry, estimator::source_count> entries_{};
  int unusable_poses_ = 0;    ///< in this tick
  bool usable_pose_ = false;  ///< one came in this tick
};

}  // namespace odomd::daemon
