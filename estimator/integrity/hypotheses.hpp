// Fault isolation: the fewest sources whose absence explains the contradiction.
//
// docs/model.md, "Integrity".
#pragma once

#include "estimator/integrity/consensus.hpp"
#include "estimator/integrity/parity.hpp"

namespace odomd::estimator::integrity {

/// A misfit above this needs an explanation. -2 log of the likelihood ratio, as all scores here.
inline constexpr double gate = 25.0;
/// The best hypothesis must be better than every other one by this.
inline constexpr double margin = 6.0;

/// v_x by all sources but the wheels [m/s].
struct WithoutWheels {
  double speed = 0.0;
  double sigma = 0.0;
};

/// The sources at fault, of those that have an equation in `all` and are not yet in `out`. `base`
/// is the solution without those in `out`. None if no hypothesis explains its misfit, or if two do
/// about equally well.
[[nodiscard]] Sources isolate_fault(const Observations& observed, const Consensus& all,
                                    const Solution& base, Sources out,
                                    const WithoutWheels& without_wheels) noexcept;

}  // namespace odomd::estimator::integrity
