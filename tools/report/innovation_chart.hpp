// The innovations of a source over time, with how far the filter expected them to lie.
#pragma once

#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include "estimator/common/measurement.hpp"
#include "tools/chart/chart.hpp"

namespace odomd::tools {

/// A chart for every dimension of every source that was tested, in the order of the sources: ν as
/// dots, gated ones in another colour, within ±3√S. Times are seconds after `zero_ns`.
[[nodiscard]] std::vector<chart::Chart> innovation_charts(
    std::span<const estimator::Judgement> judgements, std::int64_t zero_ns);

}  // namespace odomd::tools
