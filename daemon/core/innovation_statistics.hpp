// Statistics of the innovations of a source. In a consistent filter the mean of νᵀS⁻¹ν is the
// dimension of the innovation, and 95 % of the values are below χ²₉₅.
#pragma once

#include <array>
#include <cstdint>

#include "base/counter.hpp"
#include "estimator/common/measurement.hpp"

namespace odomd::daemon {

/// Counts the samples that were tested, including gated ones; inputs (without degrees of freedom)
/// are not counted. One thread writes, any may read; the numbers are recent, but may be of
/// different samples.
class InnovationStatistics {
 public:
  void take(const estimator::Judgement& judgement) noexcept;

  [[nodiscard]] std::uint64_t count() const noexcept { return count_.get(); }
  [[nodiscard]] std::uint64_t gated() const noexcept { return gated_.get(); }  ///< part of count()

  // Statistics of the counted samples; 0 if there are none.
  [[nodiscard]] int dimension() const noexcept { return static_cast<int>(dimension_.get()); }
  [[nodiscard]] double mean_nis() const noexcept;  ///< mean of νᵀS⁻¹ν; expected: dimension()
  [[nodiscard]] double inside_95() const noexcept;  ///< share with νᵀS⁻¹ν <= χ²₉₅
  [[nodiscard]] double last_test_ratio() const noexcept;  ///< νᵀS⁻¹ν / gate of the newest sample
  [[nodiscard]] std::array<double, 3> last_innovation() const noexcept;  ///< dimension() values

 private:
  Counter count_;
  Counter gated_;
  Counter dimension_;
  Counter inside_95_;
  // Bit patterns of doubles
  Counter nis_sum_;
  Counter last_test_ratio_;
  std::array<Counter, 3> last_innovation_;
};

}  // namespace odomd::daemon
