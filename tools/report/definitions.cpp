// The meaning of each figure of a report, shown where it is printed.
#include "tools/report/page.hpp"

#include <array>

namespace odomd::tools::report {
namespace {

struct Definition {
  std::string_view label;  ///< start of the labels to which it applies
  std::string_view text;
};

// The first matching entry applies.
constexpr std::array definitions{
    Definition{"samples", "instants that were compared"},
    Definition{"time span", "from the first of them to the last"},
    Definition{"path", "way driven, by the reference, else by the estimate"},
    Definition{"end error better", "how much smaller than the baseline's; negative: larger"},
    Definition{"end better", "how much smaller the end error is than the baseline's"},
    Definition{"end error [cm/m]", "end error for each metre of the path, which is per cent of it"},
    Definition{"end error",
               "distance of the last pose from the reference's, or from the start of "
               "a closed loop"},
    Definition{"end [cm/m]",
               "distance of the last pose from the reference's, or from the start of a "
               "closed loop, for each metre of the path: per cent of the way"},
    Definition{"position rms better", "how much smaller than the baseline's; negative: larger"},
    Definition{"position rms",
               "root of the mean squared distance from the reference; without the "
               "noise of a camera that is the reference"},
    Definition{"position max", "the largest distance from the reference"},
    Definition{"heading end better", "how much smaller than the baseline's; negative: larger"},
    Definition{"heading end", "heading less the reference's at the end, turns counted"},
    Definition{"heading error at the end", "heading less the reference's, turns counted"},
    Definition{"heading error rms", "root of its mean square over the drive"},
    Definition{"heading error max", "its largest magnitude"},
    Definition{"35 ms error mean better", "how much smaller than the baseline's; negative: larger"},
    Definition{"35 ms yaw", "error of the turn over seven ticks of 5 ms"},
    Definition{"35 ms",
               "error of the displacement over seven ticks of 5 ms, in the body frame: "
               "what a controller sees between two commands"},
    Definition{"1000 ms error", "the same over a second"},
    Definition{"NEES",
               "squared error over the filter's own covariance, of x, y and yaw. 3: the "
               "sigmas fit the errors; above: too small. None if the alignment removes what "
               "the filter did not know at the start"},
    Definition{"NIS factor",
               "by what factor the squared innovations are off what the filter "
               "expects, as geometric mean over the sources. Needs no reference"},
    Definition{"vx rms", "root mean square of the error of the speed ahead"},
    Definition{"vy rms", "the same of the speed to the left"},
    Definition{"yaw rate rms", "the same of the yaw rate"},
    Definition{"fused", "samples that the filter used"},
    Definition{"gated", "samples left out because they were too far from what it expected"},
    Definition{"late", "samples older than its window"},
    Definition{"other", "samples not used for other reasons"},
    Definition{"tested", "samples compared with what the filter expected"},
    Definition{"NIS / expected",
               "mean squared innovation over what the filter expects. 1: the noise "
               "is right; above: set too small; below: too large"},
    Definition{"inside 95 %", "share of samples within the filter's own 95 % limit; 95 is right"},
    Definition{"value", "learnt by the filter, at the end"},
    Definition{"3σ", "three standard deviations of it"},
};

}  // namespace

std::string definition_of(std::string_view label) {
  for (const Definition& one : definitions)
    if (label.starts_with(one.label)) return std::string{one.text};
  return {};
}

}  // namespace odomd::tools::report
