// How the samples of a source lay to what the filter expected of them. A filter that knows its own
// uncertainty has a mean νᵀS⁻¹ν of the innovation's dimension, and 95 % of them inside χ²₉₅.
#pragma once

#include <array>
#include <cstdint>

#include "base/counter.hpp"
#include "estimator/common/measurement.hpp"

namespace odomd::daemon {

/// Counts the samples that were tested, gated ones too. Inputs (of no degrees of freedom) are not.
/// One thread takes, any may read: each number for itself is some recent one.
class InnovationStatistics {
 public:
  void take(const estimator::Judgement& judgement) noexcept;

  [[nodiscard]] std::uint64_t count() const noexcept { return count_.get(); }
  [[nodiscard]] std::uint64_t gated() const noexcept { return gated_.get(); }  ///< of these

  // Of those counted; 0 while there are none.
  [[nodiscard]] int dimension() const noexcept { return static_cast<int>(dimension_.get()); }
  [[nodiscard]] double mean_nis() const noexcept;   ///< of νᵀS⁻¹ν; expected: dimension()
  [[nodiscard]] double inside_95() const noexcept;  ///< share with νᵀS⁻¹ν <= χ²₉₅
  [[nodiscard]] double last_test_ratio() const noexcept;  ///< νᵀS⁻¹ν of the newest, over its gate
  [[nodiscard]] std::array<double, 3> last_innovation() const noexcept;  ///< first dimension()

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
