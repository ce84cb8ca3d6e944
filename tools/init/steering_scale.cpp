// In a steady turn δ = l ψ̇ / v + K v ψ̇, with the understeer gradient K. The measured angle is the
// ratio times δ plus an offset. Least squares over the whole drive determine ratio, K and offset,
// with a typical K as the prior.
#include "tools/init/proposal.hpp"

#include <Eigen/Dense>
#include <algorithm>
#include <array>
#include <cmath>

#include <fmt/format.h>

#include "can_protocol/decode/units.hpp"
#include "tools/identify/common/measured.hpp"
#include "tools/init/words.hpp"

namespace odomd::tools {
namespace {

using estimator::Source;

/// Measured angle / angle of the front wheels. At constant speed both terms are proportional to
/// each other, and only the prior separates them.
std::optional<Measured> ratio_of(const DriveCourse& drive, double wheelbase) {
  const Eigen::ArrayXd &angle = drive.of(Source::steering), &yaw = drive.of(Source::yaw_rate);
  const Eigen::ArrayXd slow = (wheelbase * yaw / drive.speed).atan();
  const Eigen::Index n = angle.size();
  const Relation rough = relation_of(angle, slow);
  if (!(std::fabs(rough.slope) > 0.0)) return std::nullopt;
  Eigen::MatrixXd x(n, 3);
  x << slow, yaw * drive.speed, Eigen::ArrayXd::Ones(n);
  const Eigen::VectorXd y = angle;
  const auto rest = [&](const Eigen::Vector3d& b) { return (y - x * b).squaredNorm(); };
  // The points of a second are correlated and count as one.
  constexpr double together = 20.0;
  const double spread = (y.array() - y.mean()).square().sum();
  const double expected = typical_for(wheelbase).understeer();
  const Eigen::Vector3d prior = Eigen::Vector3d(-expected, 1.0, 0.0) / (rough.slope * expected);
  double variance = together * spread / static_cast<double>(n);
  const double least = 1e-6 * variance;
  Eigen::Vector3d found = Eigen::Vector3d::Zero();
  Eigen::Matrix3d covariance;
  for (int round = 0; round < 3; ++round) {
    const Eigen::Matrix3d information = x.transpose() * x / variance + prior * prior.transpose();
    const Eigen::FullPivLU<Eigen::Matrix3d> inverse(information);
    if (!inverse.isInvertible()) return std::nullopt;
    covariance = inverse.inverse();
    found = covariance * x.transpose() * y / variance;
    variance = std::max(together * rest(found) / static_cast<double>(n), least);
  }
  const double unexplained = rest(found) / spread;
  if (!(unexplained < 1.0) || !(std::fabs(found[0]) > 0.0)) return std::nullopt;
  // The gyro's noise makes the slope too small: sigma is half the distance to slope / R².
  const double noise = 0.5 * found[0] * unexplained / (1.0 - unexplained);
  return Measured{found[0], std::hypot(std::sqrt(covariance(0, 0)), noise)};
}

/// The largest angle [rad] in the log or, without a log, in the database.
double largest_angle(const Choice& choice) {
  const can::Signal& signal = *choice.candidate.signal;
  double largest =
      can::si_factor(choice.candidate.unit) * std::max(-signal.minimum, signal.maximum);
  if (!choice.series.empty()) largest = 0.0;
  for (const double value : choice.series.value) largest = std::max(largest, std::fabs(value));
  return largest;
}

bool names_steering_wheel(const Candidate& candidate) {
  const can::NameWords words = split_words(candidate.signal->name);
  return has(words, std::to_array<std::string_view>({"wheel", "whl", "lenkrad", "volant"}));
}

}  // namespace

void detect_command(Proposal& proposal) {
  if (!proposal.has(Source::steering)) return;
  Choice& choice = *proposal.of(Source::steering);
  const can::Signal& signal = *choice.candidate.signal;
  constexpr double one = 1.05;
  const double factor = can::si_factor(choice.candidate.unit);
  if (can::dimension_of(can::unit_of_text(signal.unit).value_or(can::Unit::none)) !=
      can::Dimension::none)
    return;
  const bool within = choice.series.empty() ? signal.maximum > signal.minimum &&
                                                  -signal.minimum <= one && signal.maximum <= one
                                            : largest_angle(choice) <= one * factor;
  if (!within) return;
  choice.candidate.unit = can::Unit::none;
  for (double& value : choice.series.value) value /= factor;
}

void set_steering_scale(Proposal& proposal, const DriveCourse& drive, const Car& car) {
  if (!proposal.has(Source::steering)) return;
  Choice& choice = *proposal.of(Source::steering);
  constexpr double usual_ratio = 16.0, full_lock = 0.9;  // rad
  const double sign = choice.scale < 0.0 ? -1.0 : 1.0;
  const auto use = [&](double ratio) { choice.scale = sign * std::round(1e5 / ratio) / 1e5; };
  const bool is_command = choice.candidate.unit == can::Unit::none;
  if (is_command && car.full_lock) {
    use(1.0 / *car.full_lock);
    choice.reasons.emplace_back("scale: the angle at full lock as given");
    return;
  }
  if (!is_command && car.steering_ratio) {
    use(*car.steering_ratio);
    choice.reasons.emplace_back("scale: one over the steering ratio as given");
    return;
  }
  const bool compares =
      drive.has(Source::steering) && drive.has(Source::yaw_rate) && drive.has_motion();
  const auto ratio = car.wheelbase && compares ? ratio_of(drive, *car.wheelbase) : std::nullopt;
  constexpr double min_front = 0.4, max_front = 2.5, min_steering_wheel = 10.0, max_ratio = 40.0;
  constexpr double precise = 0.15;
  const bool is_precise = ratio && ratio->sigma < precise * ratio->value;
  if (is_command) {
    if (ratio && ratio->value > 0.0) use(ratio->value);
    choice.scale_fits = is_precise;
    if (is_precise)
      choice.reasons.push_back(fmt::format("scale: {:.2f} ± {:.2f} rad at 1 fits the turns",
                                           1.0 / ratio->value,
                                           ratio->sigma / (ratio->value * ratio->value)));
    else
      choice.warnings.emplace_back("a command without a unit: give --full-lock");
    return;
  }
  if (is_precise && ratio->value > min_front && ratio->value < max_front) {
    choice.reasons.push_back(
        fmt::format("the front wheels' angle: {:.2f} ± {:.2f} times the angle that the turns need",
                    ratio->value, ratio->sigma));
    return;
  }
  if (is_precise && ratio->value > max_front && ratio->value < max_ratio) {
    use(ratio->value);
    choice.reasons.push_back(fmt::format("scale: a ratio of {:.1f} ± {:.1f} fits the turns",
                                         ratio->value, ratio->sigma));
    if (ratio->value < min_steering_wheel)
      choice.warnings.emplace_back(
          "few steering wheels have so small a ratio: check it, and the unit");
    return;
  }
  constexpr double clear = 2.0;  // sigmas
  const bool turns_more = ratio && ratio->value - clear * ratio->sigma > max_front;
  if (turns_more || largest_angle(choice) > full_lock || names_steering_wheel(choice.candidate)) {
    use(usual_ratio);
    choice.warnings.emplace_back(
        "the steering wheel's angle, judging by name, size or turns; its ratio is a guess: "
        "give --steering-ratio");
  } else {
    choice.warnings.emplace_back(
        "assumed to be the front wheels' angle, as the log does not show it; if it is the steering "
        "wheel's, give --steering-ratio");
  }
}

}  // namespace odomd::tools
