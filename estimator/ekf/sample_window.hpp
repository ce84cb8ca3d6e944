// The recent samples, ordered by their own times, so that the filter sees the same sequence
// whatever the order of arrival; and their verdicts, each reported once.
//
// docs/model.md, "Late samples".
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <span>
#include <tuple>
#include <utility>

#include "estimator/common/measurement.hpp"

namespace odomd::estimator::full {

/// A sample of any source. Signals use the first value and sigma; the camera has x, y, yaw.
struct Sample {
  std::int64_t time_ns = 0;
  Source source = Source::yaw_rate;
  bool judged = false;  ///< its verdict has been reported
  std::array<double, 3> value{};
  std::array<double, 3> sigma{};
  double advanced_s = 0.0;  ///< time_ns is earlier than stated by this learnt latency
};

/// A total order: by time, then by source, then by the numbers.
[[nodiscard]] inline bool operator<(const Sample& a, const Sample& b) noexcept {
  return std::tie(a.time_ns, a.source, a.value, a.sigma) <
         std::tie(b.time_ns, b.source, b.value, b.sigma);
}

/// Result of inserting a sample.
enum class Insertion : std::uint8_t { inserted, duplicate, replaced, dropped };

class SampleWindow {
 public:
  static constexpr std::size_t capacity = 1024;

  /// Inserts a sample. Of two samples with the same source and time, the first in the order above
  /// is kept; `replaced`: the new sample is kept, and takes over `judged` from the old one. A full
  /// window drops the oldest sample, which may be the new one.
  Insertion insert(const Sample& sample) noexcept;

  /// Removes the samples up to `time_ns`, or after it.
  void forget_until(std::int64_t time_ns) noexcept { begin_ += until(time_ns).size(); }
  void forget_after(std::int64_t time_ns) noexcept { end_ -= after(time_ns).size(); }

  /// The samples up to `time_ns`, or after it, in order.
  [[nodiscard]] std::span<const Sample> until(std::int64_t time_ns) const noexcept {
    return {samples_.data() + begin_, end_of(time_ns) - begin_};
  }
  [[nodiscard]] std::span<Sample> after(std::int64_t time_ns) noexcept {
    return {samples_.data() + end_of(time_ns), end_ - end_of(time_ns)};
  }

  /// Samples of each source that a full window has dropped without a verdict since the last call.
  /// Those that insert() has refused do not count.
  [[nodiscard]] std::array<std::uint32_t, source_count> take_dropped() noexcept {
    return std::exchange(dropped_, {});
  }

  /// The latest time of a dropped sample; the lowest int64 if there is none.
  [[nodiscard]] std::int64_t dropped_until_ns() const noexcept { return dropped_until_ns_; }

 private:
  /// Index after the last sample up to `time_ns`.
  [[nodiscard]] std::size_t end_of(std::int64_t time_ns) const noexcept;

  std::array<Sample, 2 * capacity> samples_{};
  std::size_t begin_ = 0;
  std::size_t end_ = 0;
  std::array<std::uint32_t, source_count> dropped_{};
  std::int64_t dropped_until_ns_ = std::numeric_limits<std::int64_t>::min();
};

class Judgements {
 public:
  void clear() noexcept { count_ = 0; }

  /// The capacity suffices for every sample of the window and one report for each source.
  void report(const Judgement& judgement) noexcept {
    if (count_ < reported_.size()) {
      reported_[count_++] = judgement;
    }
  }

  /// Reports `verdict` for the samples that have none yet.
  void refuse(std::span<const Sample> samples, Verdict verdict) noexcept {
    for (const Sample& sample : samples) {
      if (!sample.judged) {
        report({.source = sample.source, .verdict = verdict, .time_ns = sample.time_ns});
      }
    }
  }

  /// Reports the number of samples that a full window has dropped.
  void report_dropped(SampleWindow& window) noexcept {
    const std::array<std::uint32_t, source_count> dropped = window.take_dropped();
    for (const Source source : all_sources) {
      if (const std::uint32_t count = dropped[index_of(source)]; count > 0) {
        report({.source = source,
                .verdict = Verdict::too_old,
                .time_ns = window.dropped_until_ns(),
                .count = count});
      }
    }
  }

  [[nodiscard]] std::span<const Judgement> reported() const noexcept {
    return {reported_.data(), count_};
  }

 private:
  std::array<Judgement, SampleWindow::capacity + source_count> reported_{};
  std::size_t count_ = 0;
};

}  // namespace odomd::estimator::full
