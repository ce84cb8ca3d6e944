// Counters and statistics of a pipeline, by source and by frame. One thread writes, any may read
// while the beat runs; the numbers are recent, but may be of different samples or ticks.
#pragma once

#include <array>
#include <bit>
#include <cstdint>

#include "base/counter.hpp"
#include "can_protocol/decode/decoder.hpp"
#include "can_protocol/sources/stamp_guard.hpp"
#include "estimator/common/measurement.hpp"

namespace odomd::daemon {

/// A signed time or a double, as the bit pattern in a counter.
template <typename Number>
class SharedNumber {
 public:
  void set(Number value) noexcept { bits_.set(std::bit_cast<std::uint64_t>(value)); }
  [[nodiscard]] Number get() const noexcept { return std::bit_cast<Number>(bits_.get()); }

 private:
  Counter bits_;
};

/// Statistics of the innovations of a source: of the samples that were tested, including gated
/// ones; inputs (without degrees of freedom) are not counted. In a consistent filter the mean of
/// νᵀS⁻¹ν is the dimension of the innovation, and 95 % of the values are below χ²₉₅.
class InnovationStatistics {
 public:
  void take(const estimator::Judgement& judgement) noexcept;

  [[nodiscard]] std::uint64_t count() const noexcept { return count_.get(); }
  [[nodiscard]] std::uint64_t gated() const noexcept { return gated_.get(); }  ///< part of count()

  // Statistics of the counted samples; 0 if there are none.
  [[nodiscard]] int dimension() const noexcept { return static_cast<int>(dimension_.get()); }
  [[nodiscard]] double mean_nis() const noexcept;  ///< mean of νᵀS⁻¹ν; expected: dimension()
  [[nodiscard]] double inside_95() const noexcept;  ///< share with νᵀS⁻¹ν <= χ²₉₅
  /// νᵀS⁻¹ν / gate of the newest sample
  [[nodiscard]] double last_test_ratio() const noexcept { return last_test_ratio_.get(); }
  [[nodiscard]] std::array<double, 3> last_innovation() const noexcept;  ///< dimension() values

 private:
  Counter count_;
  Counter gated_;
  Counter dimension_;
  Counter inside_95_;
  SharedNumber<double> nis_sum_;
  SharedNumber<double> last_test_ratio_;
  std::array<SharedNumber<double>, 3> last_innovation_;
};

/// The noise that the filter estimates for a source.
class NoiseStatistics {
 public:
  void set(const estimator::SourceNoise& noise) noexcept;
  [[nodiscard]] estimator::SourceNoise get() const noexcept;

 private:
  SharedNumber<double> stated_, at_rest_, moving_, speed_share_;
};

struct SourceStatistics {
  std::array<Counter, estimator::verdict_count> verdicts;
  SharedNumber<std::int64_t> last_time_ns;  ///< when the newest sample was taken
  Counter last_verdict;                     ///< an estimator::Verdict
  Counter flag;                             ///< an estimator::SourceFlag, at the last tick
  Counter wiring;                           ///< a WiringFault, at the last tick
  Counter inconsistent;  ///< 1: at the last tick the NIS had been too large for seconds
  /// Camera only: from the capture of the newest pose to its arrival.
  SharedNumber<std::int64_t> last_latency_ns;
  SharedNumber<double> last_test_ratio;  ///< camera only: νᵀS⁻¹ν / gate
  InnovationStatistics innovations;      ///< for models that test each sample
  NoiseStatistics noise;                 ///< at the last tick, for models that estimate it

  /// The samples that got a verdict.
  [[nodiscard]] std::uint64_t judged() const noexcept;
};

struct PipelineStatistics {
  std::array<SourceStatistics, estimator::source_count> sources;
  std::array<Counter, can::frame_verdict_count> frames;
  std::array<Counter, can::stamp_verdict_count> stamps;
  Counter camera_malformed;  ///< messages with a wrong size, magic, version or clock
};

}  // namespace odomd::daemon
