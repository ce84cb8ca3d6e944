// In a steady turn δ = l ψ̇ / v + K v ψ̇, with the understeer K. The measured angle is the ratio
// times that, plus an offset: three unknowns, by least squares over all of the drive.
#include "tools/init/steering_scale.hpp"

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>

#include <fmt/format.h>

#include "can_protocol/decode/units.hpp"

namespace odomd::tools {
namespace {

using estimator::Source;

struct Ratio {
  double value = 0.0;
  double sigma = 0.0;
};

/// Of the measured angle over the front wheels'.
std::optional<Ratio> ratio_of(const DriveCourse& drive, double wheelbase) {
  const auto angle = drive.moving([&](std::size_t i) { return drive.at(Source::steering, i); });
  const auto slow = drive.moving([&](std::size_t i) {
    return std::atan(wheelbase * drive.at(Source::yaw_rate, i) / drive.speed(i));
  });
  const auto fast =
      drive.moving([&](std::size_t i) { return drive.at(Source::yaw_rate, i) * drive.speed(i); });
  const auto n = static_cast<Eigen::Index>(angle.size());
  Eigen::MatrixXd x(n, 3);
  Eigen::VectorXd y(n);
  for (Eigen::Index i = 0; i < n; ++i) {
    const auto k = static_cast<std::size_t>(i);
    x.row(i) << slow[k], fast[k], 1.0;
    y[i] = angle[k];
  }
  // At one speed both terms are the same: then only their sum is known.
  const Eigen::MatrixXd centred = x.leftCols<2>().rowwise() - x.leftCols<2>().colwise().mean();
  const Eigen::Matrix2d moments = centred.transpose() * centred;
  const double alike = moments(0, 1) * moments(0, 1) / (moments(0, 0) * moments(1, 1));
  constexpr double too_much = 0.9;
  if (!(alike < too_much)) return std::nullopt;
  const Eigen::Matrix3d information = x.transpose() * x;
  const Eigen::FullPivLU<Eigen::Matrix3d> inverse(information);
  if (!inverse.isInvertible()) return std::nullopt;
  const Eigen::Vector3d found = inverse.solve(x.transpose() * y);
  // points that hang together over a second count as one
  constexpr double together = 20.0;
  const double variance =
      (y - x * found).squaredNorm() / std::max(1.0, static_cast<double>(n) / together - 3.0);
  return Ratio{found[0], std::sqrt(variance * inverse.inverse()(0, 0))};
}

/// The measured angle over that of a turn without slip: enough to separate front wheels, about 1,
/// from a steering wheel, 10 or more, also at one speed.
std::optional<double> rough_ratio(const DriveCourse& drive, double wheelbase) {
  const Relation relation =
      relation_of(drive.moving([&](std::size_t i) { return drive.at(Source::steering, i); }),
                  drive.moving([&](std::size_t i) {
                    return std::atan(wheelbase * drive.at(Source::yaw_rate, i) / drive.speed(i));
                  }));
  if (!relation.clear()) return std::nullopt;
  return relation.slope;
}

/// The largest angle that the signal had; without a log, can have [rad].
double largest_angle(const Choice& choice) {
  const can::Signal& signal = *choice.candidate.signal;
  double largest = choice.series.empty() ? can::si_factor(choice.candidate.unit) *
                                               std::max(-signal.minimum, signal.maximum)
                                         : 0.0;
  for (const double value : choice.series.value) largest = std::max(largest, std::fabs(value));
  return largest;
}

}  // namespace

void set_steering_scale(Proposal& proposal, const DriveCourse& drive, const Known& known) {
  if (!proposal.has(Source::steering)) return;
  Choice& choice = *proposal.of(Source::steering);
  constexpr double usual_ratio = 16.0, full_lock = 0.9;  // rad
  const double sign = choice.scale < 0.0 ? -1.0 : 1.0;
  const auto use = [&](double ratio) { choice.scale = sign * std::round(1e5 / ratio) / 1e5; };
  if (known.steering_ratio) {
    use(*known.steering_ratio);
    choice.reasons.emplace_back("scale: one over the steering ratio as given");
    return;
  }
  const bool compares =
      drive.has(Source::steering) && drive.has(Source::yaw_rate) && drive.has_motion();
  const auto ratio = known.wheelbase && compares ? ratio_of(drive, *known.wheelbase) : std::nullopt;
  constexpr double precise = 0.1, wheels_at_most = 1.5, steering_wheel = 10.0, most = 40.0;
  if (ratio && ratio->sigma < precise * std::fabs(ratio->value)) {
    if (ratio->value > 1.0 / wheels_at_most && ratio->value < wheels_at_most) {
      choice.reasons.push_back(
          fmt::format("the front wheels' angle: {:.2f} ± {:.2f} times what the turns need",
                      ratio->value, ratio->sigma));
      return;
    }
    if (ratio->value > wheels_at_most && ratio->value < most) {
      use(ratio->value);
      choice.reasons.push_back(fmt::format("scale: a ratio of {:.1f} ± {:.1f} fits the turns",
                                           ratio->value, ratio->sigma));
      if (ratio->value < steering_wheel)
        choice.warnings.emplace_back(
            "few steering wheels have so small a ratio: check it, and the unit");
      return;
    }
  }
  constexpr double front_least = 0.4, front_most = 4.0;
  const auto rough =
      known.wheelbase && compares ? rough_ratio(drive, *known.wheelbase) : std::nullopt;
  if (rough && *rough > front_least && *rough < front_most) {
    choice.reasons.push_back(
        fmt::format("the front wheels' angle: {:.2f} times that of turns without slip", *rough));
    return;
  }
  if (largest_angle(choice) > full_lock) {
    use(usual_ratio);
    choice.warnings.emplace_back(
        "larger than front wheels turn, so the steering wheel's; its ratio is a guess: give "
        "--steering-ratio");
  } else {
    choice.warnings.emplace_back(
        "taken as the front wheels' angle: the log does not say; if it is the steering wheel's, "
        "give "
        "--steering-ratio");
  }
}

}  // namespace odomd::tools
