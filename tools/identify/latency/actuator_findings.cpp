#include "tools/identify/latency/steering_response.hpp"

#include <algorithm>
#include <cmath>
#include <string_view>

#include "daemon/diagnostics/diagnostic.hpp"
#include "tools/cli/text.hpp"

namespace odomd::tools {
namespace {

constexpr double chance = 3.0;  // standard uncertainties
// Known: the whole to 10 ms, or a tenth where that is no more than 20 ms; delay and lag to a
// quarter of the whole.
constexpr double known_below = 0.01, known_at_most = 0.02, known_share = 0.1,
                 separable_below = 0.25;
constexpr double longest_delay = 0.5, longest_lag = 1.0;  // that the configuration takes [s]

std::string milliseconds(const Measured& time) {
  return fixed(1e3 * time.value, 0) + " +- " + fixed(1e3 * time.sigma, 0) + " ms";
}

/// Why the two are not determined; empty where they are.
std::string reason_undetermined(const SteeringResponse& response, const Measured& whole,
                                const Measured& delay, const Measured& lag) {
  if (!response.failure.empty()) return response.failure;
  if (!(whole.sigma < std::clamp(known_share * whole.value, known_below, known_at_most)))
    return milliseconds(whole) + " in total; drive with more turns and changes of speed";
  if (whole.value < chance * whole.sigma)
    return "none visible, " + milliseconds(whole) +
           " in total: as expected if the angle is measured";
  if (!(std::max(delay.sigma, lag.sigma) < separable_below * whole.value))
    return "cannot be separated; delay and lag together " + milliseconds(whole);
  if (delay.value > longest_delay || lag.value > longest_lag)
    return milliseconds(whole) +
           " in total, more than [steering] allows: is it the car's steering?";
  return "";
}

Finding finding_of(std::string_view name, std::string_view key, const Measured& time) {
  Finding finding{.name = std::string(name),
                  .key = std::string(key),
                  .value = std::max(time.value, 0.0),
                  .sigma = time.sigma,
                  .unit = "s",
                  .share = Share::meaningless};
  if (time.value < 0.0)
    finding.remark =
        "measured " + fixed(1e3 * time.value, 1) + " ms, but a latency cannot be negative";
  return finding;
}

}  // namespace

ActuatorFindings actuator_findings(const SteeringResponse& response, const Measured& clock,
                                   const estimator::SteeringActuator& configured) {
  const auto by_clock = [&clock](const Measured& time) {
    return Measured{time.value - clock.value, std::hypot(time.sigma, clock.sigma)};
  };
  const Measured whole = by_clock(response.in_all);
  const Measured delay = by_clock(response.dead_time);
  const Measured lag = response.time_constant;
  ActuatorFindings found;
  found.values = {finding_of("... of this delay", "steering.delay", delay),
                  finding_of("... and lag", "steering.lag", lag)};
  if (response.rate_limit)
    found.values.push_back({.name = "... and no quicker than",
                            .key = "steering.rate_limit",
                            .value = response.rate_limit->value,
                            .sigma = response.rate_limit->sigma,
                            .unit = "rad/s"});
  const std::string failure = reason_undetermined(response, whole, delay, lag);
  if (failure.empty()) return found;
  for (Finding& finding : found.values) {
    finding.determined = Determined::no;
    finding.key.clear();
    finding.remark = failure;
  }
  const double expected = configured.delay_s + configured.lag_s;
  if (response.failure.empty() && std::abs(whole.value - expected) > chance * whole.sigma &&
      expected > 0.0)
    found.warnings.push_back(
        diagnostics::found(diagnostics::kind("actuator_not_seen"), "[steering]",
                           "has " + fixed(1e3 * expected, 0) +
                               " ms of delay and lag, the drive shows " + milliseconds(whole)));
  return found;
}

}  // namespace odomd::tools
