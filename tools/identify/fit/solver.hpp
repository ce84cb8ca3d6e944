// Fits all parameters at once: finds those with which a single-track car with the measured steering
// matches sensors and poses best, with nonlinear least squares.
//
// Multiple shooting: the drive is cut into windows. In each the model runs from a free state, and
// its end must meet the start of the next within the model's uncertainty. The acceleration along x
// is a free function, linear between knots; v_x is its integral.
#pragma once

#include <Eigen/Core>
#include <array>
#include <cstddef>
#include <functional>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "tools/identify/fit/drive.hpp"
#include "tools/identify/fit/parameters.hpp"
#include "tools/identify/fit/window.hpp"

namespace odomd::tools::fitting {

// The unknowns of a drive: successive windows with a state at the start of each.

/// A node at the start of each window and at the end, and the unknowns inside the windows.
struct Chain {
  std::vector<Window> windows;
  std::vector<Node<double>> nodes;
  std::vector<std::vector<double>> inner;
};

/// The parts of a drive that are fast enough to show the tyres, with at least two windows each.
/// Initial nodes come from the poses, the wheels' speed, the gyro, and the corresponding slip.
[[nodiscard]] std::vector<Chain> chains_of(const Setup& setup, const FitDrive& drive);

/// Assigns each sample to the window of its time, corrected by the present latencies.
void assign_samples(const Numbers<double>& p, const Setup& setup, Chain& chain);

/// Statistics of the drive's turns, from the states at the windows' ends.
struct Turns {
  /// How little lateral acceleration and curvature are correlated: 0 at one speed, 0.46 in the
  /// exercise that the help describes.
  //
  // With κ = ψ̇ / v, a = v ψ̇ and a_0 = κ Σ a κ / Σ κ²: sqrt(Σ (a - a_0)² / Σ a²). On a circle the
  // single-track model has δ = l κ + (m l_h / C_v - m l_v / C_h) a / l: without variety, steering
  // scale and tyres are inseparable.
  double speed_variety = 0.0;
  double hard = 0.0;     ///< share of the time above 0.5 g, half of the grip of dry tyres
  double hardest = 0.0;  ///< lateral acceleration exceeded for a twentieth of the time [m/s²]
};
[[nodiscard]] Turns turns_of(const std::vector<Chain>& chains);

/// The residuals of all measurements.
struct Residuals {
  std::array<std::vector<double>, kinds> values;
  std::array<double, kinds> stated{};
};
[[nodiscard]] Residuals residuals_of(const Setup& setup, const std::vector<Chain>& chains,
                                     const Numbers<double>& p);

/// Raises the noise to that of the residuals: model errors count as noise of the source that shows
/// them. (The residuals' noise is below the stated one if a wheel is at rest for long.)
void update_noise(Setup& setup, const Residuals& residuals);

// The fit of all drives.

struct Settings {
  std::array<bool, parameters> free{};
  Numbers<double> prior_sigma{};  ///< standard deviations of p before the fit
  std::optional<Measured> rest;   ///< the gyro's bias at rest [rad/s]
  /// Relative standard uncertainty of the configured mass. A drive shows only ratios to the mass,
  /// so this adds to the uncertainty of stiffnesses and inertia.
  double mass_sigma = 0.01;
  double window = 0.5;  ///< [s]
  int passes = 3;       ///< minimum; after each, residuals give the noise, and outliers lose weight
  int threads = 1;
  std::function<void(const std::string&)> progress;  ///< called with a line now and then

  [[nodiscard]] std::vector<std::size_t> free_parameters() const;
  /// The prior of p: its value and standard deviation.
  [[nodiscard]] Measured known(std::size_t k) const;
};

/// How well a source fits after the last pass.
struct SourceFit {
  std::string name;
  std::size_t count = 0;
  double stated = 0.0;  ///< its stated noise
  double found = 0.0;   ///< robust noise of the residuals
};

struct Result {
  Numbers<double> p{};
  Numbers<double> sigma{};         ///< standard uncertainties of p; 0 for fixed ones
  Numbers<double> naive{};         ///< the same if all residuals were independent
  Eigen::MatrixXd covariance;      ///< of all p; 0 for fixed ones
  std::vector<SourceFit> sources;  ///< in the order of estimator::Source; camera: x and y, then yaw
  int iterations = 0;
  bool settled = false;  ///< converged; otherwise the passes ended
  Turns turns;
};

/// Throws std::invalid_argument for a drive that determines nothing and if no parameter is free,
/// std::runtime_error if the solver fails.
[[nodiscard]] Result solve(const daemon::Config& config, std::span<const FitDrive> drives,
                           const Settings& settings);

}  // namespace odomd::tools::fitting
