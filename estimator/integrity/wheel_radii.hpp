// By how much the wheels always read differently.
//
// docs/model.md, "Integrity".
#pragma once

#include "estimator/integrity/consensus.hpp"
#include "estimator/integrity/parity.hpp"

namespace odomd::estimator::integrity {

/// Wheels are worn and inflated differently, and give way differently where they carry more: what
/// always differs is their radius. Of `all`, held against `base`, over a time dt [s] in which no
/// source was suspected.
void learn_radii(const Sensors& sensors, const Consensus& all, const Solution& base, double dt,
                 Heard& heard) noexcept;

}  // namespace odomd::estimator::integrity
