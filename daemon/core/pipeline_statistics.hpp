// Counters and statistics of a pipeline, by source and by frame. One thread writes, any may read
// while the beat runs; the numbers are recent, but may be of different samples or ticks.
#pragma once

#include <array>
#include <bit>
#include <cstddef>
#include <cstdint>
#include <tuple>

#include "base/counter.hpp"
#include "can_protocol/decode/decoder.hpp"
#include "can_protocol/sources/stamp_guard.hpp"
#include "estimator/common/measurement.hpp"

namespace odomd::daemon {

/// A value that one thread sets and any thread may get. It is not atomic as a whole: a read may mix
/// words of two values.
template <typename T>
class Shared {
 public:
  void set(const T& value) noexcept {
    const auto words = std::bit_cast<Words>(value);
    for (std::size_t i = 0; i < words.size(); ++i) counters_[i].set(words[i]);
  }
  [[nodiscard]] T get() const noexcept {
    Words words;
    for (std::size_t i = 0; i < words.size(); ++i) words[i] = counters_[i].get();
    return std::bit_cast<T>(words);
  }

 private:
  using Words = std::array<std::uint64_t, sizeof(T) / sizeof(std::uint64_t)>;
  std::array<Counter, std::tuple_size_v<Words>> counters_;
};

/// Statistics of the innovations of a source: of the samples that were tested, including gated
/// ones; inputs (without degrees of freedom) are not counted. In a consistent filter the mean of
/// νᵀS⁻¹ν is the dimension of the innovation, and 95 % of the values are below χ²₉₅.
struct InnovationStatistics {
  std::uint64_t count = 0;
  std::uint64_t gated = 0;  ///< part of count
  std::uint64_t dimension = 0;
  std::uint64_t below_95 = 0;  ///< samples with νᵀS⁻¹ν <= χ²₉₅
  double nis_sum = 0.0;        ///< of νᵀS⁻¹ν
  // Of the newest sample.
  double test_ratio = 0.0;             ///< νᵀS⁻¹ν / gate
  std::array<double, 3> innovation{};  ///< `dimension` values

  void take(const estimator::Judgement& judgement) noexcept;

  [[nodiscard]] double mean_nis() const noexcept;   ///< mean of νᵀS⁻¹ν; 0 without samples
  [[nodiscard]] double inside_95() const noexcept;  ///< share with νᵀS⁻¹ν <= χ²₉₅
  /// The mean of νᵀS⁻¹ν divided by its expectation; there must be samples.
  [[nodiscard]] double nis_per_degree() const noexcept {
    return mean_nis() / static_cast<double>(dimension);
  }
};

struct SourceStatistics {
  std::array<Counter, estimator::verdict_count> verdicts;
  Shared<std::int64_t> last_time_ns;  ///< when the newest sample was taken
  Counter last_verdict;               ///< an estimator::Verdict
  Counter flag;                       ///< an estimator::SourceFlag, at the last tick
  Counter wiring;                     ///< a WiringFault, at the last tick
  Counter inconsistent;  ///< 1: at the last tick the NIS had been too large for seconds
  /// Camera only: from the capture of the newest pose to its arrival.
  Shared<std::int64_t> last_latency_ns;
  Shared<double> last_test_ratio;            ///< camera only: νᵀS⁻¹ν / gate
  Shared<InnovationStatistics> innovations;  ///< for models that test each sample
  Shared<estimator::SourceNoise> noise;      ///< at the last tick, for models that estimate it

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
