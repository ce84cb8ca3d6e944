// Verdicts of the samples in a step, each reported once.
//
// docs/model.md, "Late samples".
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>

#include "estimator/common/measurement.hpp"
#include "estimator/ekf/sample_window.hpp"

namespace odomd::estimator::full {

class Judgements {
 public:
  void clear() noexcept { count_ = 0; }

  /// The capacity suffices for every sample of the window and one report for each source.
  void report(const Judgement& judgement) noexcept {
    if (count_ < reported_.size()) {
      reported_[count_++] = judgement;
    }
  }

  /// Reports the samples that have no verdict yet with `verdict`.
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
    for (std::size_t i = 0; i < source_count; ++i) {
      if (dropped[i] > 0) {
        report({.source = static_cast<Source>(i),
                .verdict = Verdict::too_old,
                .time_ns = window.dropped_until_ns(),
                .count = dropped[i]});
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
