#include "tools/diagnostics/drive_mismatch.hpp"

#include <algorithm>
#include <cmath>
#include <cstdint>

namespace odomd::tools {
namespace {

constexpr std::int64_t second_ns = 1'000'000'000;
constexpr std::int64_t step_ns = second_ns / 10;
constexpr std::size_t least_samples = 20;
constexpr double least_turn = 0.1;  // rad a second, rms

bool turns_otherwise(const Trajectory& reference, const Trajectory& estimate) {
  double difference = 0.0;
  double turned = 0.0;
  std::size_t samples = 0;
  const std::int64_t last =
      std::min(reference.points.back().t_ns, estimate.points.back().t_ns) - second_ns;
  for (std::int64_t t = std::max(reference.points.front().t_ns, estimate.points.front().t_ns);
       t <= last; t += step_ns) {
    const auto reference_from = at(reference, t), reference_to = at(reference, t + second_ns);
    const auto estimate_from = at(estimate, t), estimate_to = at(estimate, t + second_ns);
    if (!reference_from || !reference_to || !estimate_from || !estimate_to) continue;
    if (estimate_to->reset_count != estimate_from->reset_count) continue;
    const double reference_turn = reference_to->pose.yaw - reference_from->pose.yaw;
    const double estimate_turn = estimate_to->pose.yaw - estimate_from->pose.yaw;
    difference += std::pow(estimate_turn - reference_turn, 2);
    turned += reference_turn * reference_turn;
    ++samples;
  }
  return samples >= least_samples &&
         turned > least_turn * least_turn * static_cast<double>(samples) &&
         !diagnostics::kind("other_drive").limits.hold(std::sqrt(difference / turned));
}

}  // namespace

std::optional<diagnostics::Diagnostic> drive_mismatch(const Trajectory& reference,
                                                      const Trajectory& estimate) {
  if (turns_otherwise(reference, estimate))
    return found(diagnostics::kind("other_drive"), estimate.name,
                 "its turns disagree with the reference's");
  if (reference.has_covariance && !estimate.has_covariance)
    return found(diagnostics::kind("exchanged"), estimate.name,
                 "the reference has sigmas and this has none");
  return std::nullopt;
}

}  // namespace odomd::tools
