#include "tools/identify/weighing/weighing.hpp"

#include <fmt/format.h>

#include <Eigen/Cholesky>
#include <Eigen/SVD>
#include <algorithm>
#include <cmath>
#include <stdexcept>

#include "tools/cli/text.hpp"
#include "tools/diagnostics/kinds.hpp"

namespace odomd::tools {
namespace {

constexpr std::array<LoadInfo, static_cast<std::size_t>(Load::count)> loads_table{{
    {"total", {1, 1, 1, 1}, "Load of the whole car"},
    {"front", {1, 1, 0, 0}, "Load of the front axle, with the rear axle at the same height"},
    {"rear", {0, 0, 1, 1}, "Load of the rear axle"},
    {"left", {1, 0, 1, 0}, "Load of the left wheels"},
    {"right", {0, 1, 0, 1}, "Load of the right wheels"},
    {"front-left", {1, 0, 0, 0}, "Load of the front left wheel, others at the same height"},
    {"front-right", {0, 1, 0, 0}, "Load of the front right wheel"},
    {"rear-left", {0, 0, 1, 0}, "Load of the rear left wheel"},
    {"rear-right", {0, 0, 0, 1}, "Load of the rear right wheel"},
}};

// Limits of load / resolution. Scales with finer steps do not exist: a unit is wrong.
constexpr double max_digits = 1e6;
constexpr double max_digits_of_heavy_loads = 2e5;
constexpr double heavy = 60.0;  // kg

bool can_show(const Scale& scale, double mass) {
  return !(scale.resolution > 0.0) ||
         mass <= (mass > heavy ? max_digits_of_heavy_loads : max_digits) * scale.resolution;
}

// Default scatter of weighings of one load, relative to the last digit.
constexpr double half_a_digit = 0.5;

Eigen::Vector4d wheels_of(Load load) {
  return Eigen::Vector4d(info_of(load).wheels.data());
}

/// Generalised least squares.
WheelLoads solve(std::span<const Weighing> weighings, const Scale& scale) {
  const auto n = static_cast<Eigen::Index>(weighings.size());
  Eigen::MatrixXd design(n, 4);
  Eigen::VectorXd shown(n);
  // The scale rounds one load the same way each time; each weighing has its own scatter.
  const double rounding = scale.resolution * scale.resolution / 12.0;
  const double scatter = scale.sigma > 0.0 ? scale.sigma : half_a_digit * scale.resolution;
  const auto shared_variance = [&](Load load) {
    const Eigen::Vector4d wheels = wheels_of(load);
    const double axle = 0.5 * wheels.dot(Eigen::Vector4d{1, 1, -1, -1}) * scale.axle_shift;
    const double side = 0.5 * wheels.dot(Eigen::Vector4d{1, -1, 1, -1}) * scale.side_shift;
    return rounding + axle * axle + side * side;
  };
  Eigen::MatrixXd variance = Eigen::MatrixXd::Zero(n, n);
  for (Eigen::Index i = 0; i < n; ++i) {
    const Weighing& weighing = weighings[static_cast<std::size_t>(i)];
    design.row(i) = wheels_of(weighing.load);
    shown(i) = weighing.mass;
    for (Eigen::Index j = 0; j < n; ++j)
      if (weighings[static_cast<std::size_t>(j)].load == weighing.load)
        variance(i, j) = shared_variance(weighing.load);
    // Keeps repeated weighings from being singular, however small the given scatter is.
    variance(i, i) += std::max(scatter * scatter, 1e-4 * rounding);
  }
  const Eigen::LLT<Eigen::MatrixXd> factor(variance);
  const Eigen::MatrixXd whitened = factor.matrixL().solve(design);
  const Eigen::VectorXd target = factor.matrixL().solve(shown);
  Eigen::JacobiSVD<Eigen::MatrixXd> svd(whitened, Eigen::ComputeThinU | Eigen::ComputeThinV);
  svd.setThreshold(1e-9);
  const Eigen::MatrixXd directions = svd.matrixV().leftCols(svd.rank());
  const Eigen::VectorXd variances =
      svd.singularValues().head(svd.rank()).cwiseAbs2().cwiseInverse();

  WheelLoads loads;
  loads.load = svd.solve(target);
  loads.covariance = directions * variances.asDiagonal() * directions.transpose();
  loads.determined = directions * directions.transpose();
  loads.chi_square = (target - whitened * loads.load).squaredNorm();
  loads.excess = static_cast<int>(n - svd.rank());
  return loads;
}

void check(std::span<const Weighing> weighings, const Scale& scale) {
  if (weighings.empty()) refuse("no load is given; weigh the car, and give --total, --front, ...");
  if (!(scale.sigma > 0.0) && !(scale.resolution > 0.0))
    throw std::invalid_argument(
        "how good is the scale? Give --scale-resolution, its last digit, or --scale-sigma");
  for (const Weighing& weighing : weighings) {
    if (!(weighing.mass > 0.0))
      refuse(
          "--{}: {} kg is not possible; it must be greater "
          "than 0",
          info_of(weighing.load).option, weighing.mass);
    if (!can_show(scale, weighing.mass))
      refuse("--{}: no scale shows {:g} kg with steps of {:g} kg; write grams as 2985g",
             info_of(weighing.load).option, weighing.mass, scale.resolution);
  }
}

/// The weight distribution: the share of the weight on some of the wheels.
std::optional<Measured> share_of(const WheelLoads& loads, const Eigen::Vector4d& wheels) {
  const Eigen::Vector4d all = Eigen::Vector4d::Ones();
  if (!loads.determine(all) || !loads.determine(wheels)) return std::nullopt;
  // s = p/m: ds = (dp - s dm)/m; the scale's gain cancels.
  const double mass = all.dot(loads.load);
  const double share = wheels.dot(loads.load) / mass;
  const Eigen::Vector4d gradient = (wheels - share * all) / mass;
  return Measured{share, std::sqrt(gradient.dot(loads.covariance * gradient))};
}

}  // namespace

const LoadInfo& info_of(Load load) {
  return loads_table[static_cast<std::size_t>(load)];
}

bool WheelLoads::determine(const Eigen::Vector4d& sum) const {
  return (determined * sum - sum).norm() < 1e-9;
}

WheelLoads wheel_loads(std::span<const Weighing> weighings, const Scale& scale) {
  check(weighings, scale);
  WheelLoads loads = solve(weighings, scale);
  // Birge (1932)
  if (loads.excess > 0) loads.covariance *= std::max(loads.chi_square / loads.excess, 1.0);
  return loads;
}

std::optional<diagnostics::Diagnostic> contradiction(const WheelLoads& loads) {
  if (loads.excess <= 0) return std::nullopt;
  // Wilson and Hilferty (1931): the cube root of chi² is nearly normal.
  const double k = 2.0 / (9.0 * loads.excess);
  const double z = (std::cbrt(loads.chi_square / loads.excess) - (1.0 - k)) / std::sqrt(k);
  if (z < 2.326) return std::nullopt;
  const double times = std::sqrt(loads.chi_square / loads.excess);
  return found(
      tools::kind("weighings_contradict"), {},
      fmt::format("the loads contradict each other {} more than the scale explains",
                  times < 100.0 ? fmt::format("{:.1f} times", times) : "a hundred times and"));
}

std::optional<Measured> mass_of(const WheelLoads& loads, const Scale& scale) {
  const Eigen::Vector4d all = Eigen::Vector4d::Ones();
  if (!loads.determine(all)) return std::nullopt;
  const double mass = all.dot(loads.load);
  const double variance = all.dot(loads.covariance * all);
  return Measured{mass, std::hypot(std::sqrt(variance), scale.accuracy * mass)};
}

void check_shares(const WheelLoads& loads) {
  for (const Load load : {Load::front, Load::rear, Load::left, Load::right}) {
    const auto share = share_of(loads, wheels_of(load));
    if (!share || share->value < 1.0) continue;
    refuse(
        "--{}: {:.4g} kg is more than the whole car, {:.4g} kg: are they exchanged, or "
        "in another unit?",
        info_of(load).option, wheels_of(load).dot(loads.load), loads.load.sum());
  }
}

Scale with_slopes(Scale scale, double mass, const Dimensions& dimensions) {
  constexpr double height = 0.25;  // of the centre of gravity / wheelbase: about right for any car
  const double moment = mass * height * dimensions.wheelbase.value * std::tan(dimensions.level);
  scale.axle_shift = moment / dimensions.wheelbase.value;
  if (dimensions.track_width) scale.side_shift = moment / dimensions.track_width->value;
  return scale;
}

CentreOfGravity centre_of_gravity(const WheelLoads& loads, const Dimensions& dimensions) {
  CentreOfGravity centre;
  if (const auto front = share_of(loads, wheels_of(Load::front))) {
    const double base = dimensions.wheelbase.value;
    const double moved = base * front->sigma;
    const double share_h = front->value;  // l_h / l = F_gv / (m g)          (eq. 22)
    const double share_v = 1.0 - share_h;
    const double tape = dimensions.wheelbase.sigma;
    centre.rear_axle = {share_h * base, std::hypot(share_h * tape, moved)};
    centre.front_axle = {share_v * base, std::hypot(share_v * tape, moved)};
    // Tape errors change both lengths the same way, load errors in opposite ways.
    const double sigmas = centre.rear_axle->sigma * centre.front_axle->sigma;
    if (sigmas > 0.0)
      centre.correlation = (share_h * share_v * tape * tape - moved * moved) / sigmas;
  }
  if (!dimensions.track_width) return centre;
  if (const auto left = share_of(loads, wheels_of(Load::left))) {
    const double width = dimensions.track_width->value;
    const double part = left->value - 0.5;
    centre.lateral = {part * width,
                      std::hypot(part * dimensions.track_width->sigma, width * left->sigma)};
  }
  return centre;
}

}  // namespace odomd::tools
