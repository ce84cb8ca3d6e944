// Radius errors of the wheels, by their constant differences.
//
// docs/model.md, "Integrity".
#pragma once

#include "estimator/integrity/consensus.hpp"
#include "estimator/integrity/parity.hpp"

namespace odomd::estimator::integrity {

/// Learns the radius error of each wheel, and the load transfer, from the residuals of `all` at
/// `base` over `dt` [s]. Call it while no source is suspected.
void learn_radii(const Sensors& sensors, const Consensus& all, const Solution& base, double dt,
                 Observations& observed) noexcept;

}  // namespace odomd::estimator::integrity
