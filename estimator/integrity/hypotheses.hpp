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

/// The sources at fault, of those that have an equation in `all` and are trusted. `base` is the
/// solution by the trusted ones, `without_wheels` that by all of them but the wheels. None if no
/// hypothesis explains the misfit of `base`, or if two do about equally well.
[[nodiscard]] Sources isolate_fault(const Observations& observed, const Consensus& all,
                                    const Solution& base, const Solution& without_wheels) noexcept;

}  // namespace odomd::estimator::integrity
