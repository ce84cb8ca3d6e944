#include "tools/doctor/doctor.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <Eigen/Core>
#include <algorithm>
#include <array>
#include <cmath>
#include <string>
#include <vector>

#include "tools/diagnostics/kinds.hpp"
#include "tools/identify/common/agreement.hpp"
#include "tools/identify/common/signal_log.hpp"
#include "tools/math/median.hpp"

namespace odomd::tools::doctor {
namespace {

using diagnostics::Diagnostic;
using diagnostics::found;
using Eigen::ArrayXd;
using estimator::Source;

// Relative errors of fault-free comparisons, due to slip, tyres, roll and slopes.
constexpr double pose_sigma = 0.02, wheel_sigma = 0.03, axle_sigma = 0.05, rest_sigma = 0.1;
constexpr double harmless = 0.07;      // relative error that the filter learns
constexpr double min_explained = 9.0;  // weighted sum of squares that the factor must explain
constexpr double min_lead = 4.0;       // lead over the next best factor, in the same sum
constexpr std::size_t min_pieces = 100;

std::vector<Piece> pieces_between_poses(const Drive& drive, const SignalLog& log) {
  constexpr double longest = 1.5;  // s
  std::vector<PoseSample> poses = in_order(drive.cameras, log.first_ns);
  auto arm = drive.config.camera.lever_arm;
  if (poses.empty() && drive.reference) {
    arm = drive.config.reference_lever_arm.value_or(arm);
    for (const TrajectoryPoint& point : drive.reference->points)
      poses.push_back({log.seconds(point.t_ns), point.pose.x, point.pose.y, point.pose.yaw});
  }
  return pieces_of(poses, 0.0, longest, arm);
}

/// ln(ratio) = Σ power · ln(scale of the source) ± sigma
struct Comparison {
  double log_ratio = 0.0, sigma = 1.0;
  std::array<double, estimator::source_count> power{};
};

struct Power {
  std::vector<Source> sources;  ///< share the power equally
  double power = 1.0;
};

void add(std::vector<Comparison>& all, double ratio, double sigma,
         std::initializer_list<Power> powers) {
  Comparison& one = all.emplace_back(Comparison{std::log(ratio), sigma, {}});
  for (const auto& [sources, power] : powers)
    for (const Source source : sources)
      one.power[index_of(source)] += power / static_cast<double>(sources.size());
}

void add_median(std::vector<Comparison>& all, const ArrayXd& y, const ArrayXd& x, double sigma,
                std::initializer_list<Power> powers) {
  const ArrayXd ratios = (y / x).abs();
  const double ratio = median_of(std::vector(ratios.begin(), ratios.end()));
  if (ratio > 0.0 && std::isfinite(ratio)) add(all, ratio, sigma, powers);
}

// Compares the magnitudes of y and x, whose ratio latencies hardly change. Noise increases sigma.
void add_slope(std::vector<Comparison>& all, const ArrayXd& y, const ArrayXd& x, double sigma,
               std::initializer_list<Power> powers) {
  constexpr double min_correlation = 0.8;
  const Relation relation = relation_of(y, x);
  if (relation.correlation > min_correlation)
    add(all, relation.gain, std::hypot(sigma, std::log(relation.correlation)), powers);
}

std::vector<Comparison> compare(const Drive& drive, const SignalLog& log,
                                const std::vector<Source>& wheels) {
  const estimator::Vehicle& car = drive.config.vehicle;
  constexpr double stride = 0.05, step = 0.01;  // s
  const double end = log.seconds(log.last_ns);
  std::vector<Piece> pieces = pieces_between_poses(drive, log);
  const bool has_poses = pieces.size() >= min_pieces;
  if (!has_poses) pieces = even_pieces(0.0, end, stride);
  const auto on_grid = [&](const Series& series) {
    return resampled(series, log.first_ns, 0.0, end, step);
  };
  const auto speed_of = [&](Source wheel) {
    return on_grid(with_direction(log.of(wheel), log.of(Source::direction)));
  };
  Resampled speed = speed_of(wheels[0]);
  for (std::size_t k = 1; k < wheels.size(); ++k)
    speed = combined(speed, speed_of(wheels[k]), std::plus{});
  for (double& value : speed.value) value /= static_cast<double>(wheels.size());
  const auto each = [&](auto f) {
    ArrayXd values(std::ssize(pieces));
    std::ranges::transform(pieces, values.begin(), f);
    return values;
  };
  const auto mean = [&](const Resampled& signal) {
    return each([sum = integral(signal)](const Piece& piece) {
      return (sum.at(piece.to) - sum.at(piece.from)) / piece.length();
    });
  };
  const ArrayXd all_speeds = mean(speed).abs();
  const double slowest =
      pieces.empty() ? 0.0 : std::max(0.5 * median_of_magnitudes(all_speeds), 0.1);
  std::erase_if(
      pieces, [&, i = Eigen::Index{0}](const Piece&) mutable { return all_speeds[i++] < slowest; });
  std::vector<Comparison> all;
  if (pieces.size() < min_pieces || !log.has(Source::yaw_rate)) return all;

  const std::vector<Source> gyro{Source::yaw_rate};
  const ArrayXd v = mean(speed), turn = mean(on_grid(log.of(Source::yaw_rate)));
  const ArrayXd seen_speed = each([](const Piece&p) { return p.along / p.length(); }),
                seen_turn = each([](const Piece&p) { return p.turn / p.length(); });
  std::vector<ArrayXd> middle;  // speed of the middle of the axle, from each wheel
  for (const Source wheel : wheels) {
    const double left = wheel_place(car, wheel).left;
    middle.push_back(mean(speed_of(wheel)) + left * (has_poses ? seen_turn : turn));
    if (has_poses)
      add_median(all, middle.back(), seen_speed, pose_sigma, {{{wheel}}});
    else if (wheel != wheels[0])
      add_median(all, middle.back(), middle[0], wheel_sigma, {{{wheel}}, {{wheels[0]}, -1.0}});
  }
  if (has_poses) add_slope(all, turn, seen_turn, pose_sigma, {{gyro}});
  for (const auto& [left, right] : estimator::wheel_pairs)
    if (log.has(left) && log.has(right))
      // Divided by v, the effect of a factor on one wheel is constant.
      add_slope(all, (mean(speed_of(right)) - mean(speed_of(left))) / v, car.track_width * turn / v,
                axle_sigma, {{{left, right}}, {gyro, -1.0}});
  if (log.has(Source::steering))
    add_slope(all, mean(on_grid(log.of(Source::steering))),
              car.wheelbase() * turn / v + car.mass / car.wheelbase() * v * turn *
                                               (car.rear_axle / car.cornering_stiffness_front -
                                                car.front_axle / car.cornering_stiffness_rear),
              rest_sigma, {{{Source::steering}}, {wheels}, {gyro, -1.0}});
  if (log.has(Source::accel_y))
    add_slope(all, mean(on_grid(log.of(Source::accel_y))), v * turn, rest_sigma,
              {{{Source::accel_y}}, {wheels, -1.0}, {gyro, -1.0}});
  if (log.has(Source::accel_x))
    add_slope(all, mean(on_grid(log.of(Source::accel_x))), each([&](const Piece& piece) {
                return (speed.at(piece.to) - speed.at(piece.from)) / piece.length();
              }),
              rest_sigma, {{{Source::accel_x}}, {wheels, -1.0}});
  return all;
}

struct Suspect {
  std::vector<Source> sources;  ///< with a common factor
  double factor = 1.0, explained = 0.0;
};

}  // namespace

std::optional<Diagnostic> find_wrong_scale(const Drive& drive, const SignalLog& log) {
  std::vector<Source> wheels;
  std::ranges::copy_if(wheel_sources, std::back_inserter(wheels),
                       [&](Source wheel) { return log.has(wheel); });
  if (wheels.empty()) return std::nullopt;
  std::vector<Suspect> suspects{
      {wheels}, {{Source::yaw_rate}}, {{Source::steering}}, {{Source::accel_x, Source::accel_y}}};
  for (const auto& [left, right] : estimator::wheel_pairs) suspects.push_back({{left, right}});
  for (const Source wheel : wheels) suspects.push_back({{wheel}});
  const std::vector<Comparison> all = compare(drive, log, wheels);
  for (auto& [sources, factor, explained] : suspects) {
    std::erase_if(sources, [&](Source source) { return !log.has(source); });
    double square = 0.0, product = 0.0;
    for (const Comparison& one : all) {
      double power = 0.0;
      for (const Source source : sources) power += one.power[index_of(source)] / one.sigma;
      square += power * power;
      product += power * one.log_ratio / one.sigma;
    }
    if (!(square > 0.0)) continue;
    factor = std::exp(product / square);
    explained = product * product / square;
  }
  std::ranges::stable_sort(suspects, std::greater{}, &Suspect::explained);
  const Suspect& worst = suspects[0];
  const auto next = std::ranges::find_if(
      suspects, [&](const Suspect& other) { return other.sources != worst.sources; });
  if (worst.explained < std::max(min_explained, next->explained + min_lead) ||
      std::fabs(std::log(worst.factor)) < harmless)
    return std::nullopt;
  std::vector<std::string> names;
  for (const Source source : worst.sources) names.push_back(name_of(source));
  return found(kind("scale_off"), fmt::format("{}", fmt::join(names, ", ")),
               fmt::format("{:.2f} times what the other sensors show", worst.factor),
               fmt::format("can.signals.{}", fmt::join(names, ", can.signals.")));
}

}  // namespace odomd::tools::doctor
