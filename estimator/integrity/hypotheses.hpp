// Which sources are at fault: the fewest whose absence explains that the others contradict each
// other.
//
// docs/model.md, "Integrity".
#pragma once

#include "estimator/integrity/consensus.hpp"
#include "estimator/integrity/parity.hpp"

namespace odomd::estimator::integrity {

/// By so much a hypothesis must explain more than that all is well, and than another one (-2 log of
/// the likelihoods' ratio).
inline constexpr double gate = 25.0;
inline constexpr double margin = 6.0;

/// v_x by all but the wheels [m/s].
struct WithoutWheels {
  double speed = 0.0;
  double sigma = 0.0;
};

/// Of the sources that are heard in `all` and not yet `out`, those that are at fault; none where
/// nothing explains the misfit of `base`, which is without those that are out, or where one word
/// stands against another.
[[nodiscard]] Sources suspects(const Heard& heard, const Consensus& all, const Solution& base,
                               Sources out, const WithoutWheels& without_wheels) noexcept;

}  // namespace odomd::estimator::integrity
