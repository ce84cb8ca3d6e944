// Which sources are alive: when each was last heard, how old its newest sample is, and whether it
// is overdue. Pure logic on given times; the pipeline's, on its clock.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>

#include "estimator/common/measurement.hpp"

namespace odomd::daemon {

class SourceWatch {
 public:
  /// A source that the configuration names; unheard for longer than the time-out it is overdue.
  void configure(std::size_t source, std::int64_t timeout_ns) noexcept {
    entries_[source].configured = true;
    entries_[source].timeout_ns = timeout_ns;
  }

  /// A sample came in at `heard_ns` that was taken at `taken_ns`.
  void heard(std::size_t source, std::int64_t heard_ns, std::int64_t taken_ns) noexcept {
    Entry& entry = entries_[source];
    entry.seen = true;
    entry.failing = false;
    entry.heard_ns = heard_ns;
    entry.taken_ns = taken_ns;
  }

  /// A frame that feeds the source failed its protection.
  void failed(std::size_t source) noexcept { entries_[source].failing = true; }

  /// Age of the newest sample [ns]; -1: never seen.
  [[nodiscard]] std::int64_t age_ns(std::size_t source, std::int64_t now_ns) const noexcept {
    return entries_[source].seen ? now_ns - entries_[source].taken_ns : -1;
  }

  /// Configured, but not heard for its time-out. A source that was never heard has as long, from
  /// `start_ns` on.
  [[nodiscard]] bool overdue(std::size_t source, std::int64_t now_ns,
                             std::int64_t start_ns) const noexcept {
    const Entry& entry = entries_[source];
    const std::int64_t since = entry.seen ? entry.heard_ns : start_ns;
    return entry.configured && now_ns - since > entry.timeout_ns;
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
    std::int64_t timeout_ns = 0;
    std::int64_t heard_ns = 0;
    std::int64_t taken_ns = 0;
  };
  std::array<Entry, estimator::source_count> entries_{};
};

}  // namespace odomd::daemon
