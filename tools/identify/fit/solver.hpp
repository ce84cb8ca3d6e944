// Everything at once: the parameters that make a single-track car, driven by the measured steering,
// feel and go what sensors and poses say it did, by nonlinear least squares.
//
// Multiple shooting: the drive is cut into windows; in each the model runs from a state that is
// free, and its end has to meet the next one's beginning within what the model is believed. The
// acceleration along x is a free function, linear between knots; v_x is its integral.
#pragma once

#include <Eigen/Core>
#include <array>
#include <functional>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "tools/identify/fit/chain.hpp"
#include "tools/identify/fit/drive.hpp"
#include "tools/identify/fit/parameters.hpp"

namespace odomd::tools::fitting {

struct Settings {
  std::array<bool, parameters> free{};
  Numbers<double> doubt{};       ///< standard deviations of p beforehand
  std::optional<Measured> rest;  ///< the gyro's bias as it shows at rest [rad/s]
  Numbers<double> start{};       ///< p to begin with

  /// All that is known of p beforehand: its value, and its standard deviation.
  [[nodiscard]] Measured known(std::size_t k) const;
  double window = 0.5;  ///< [s]
  int most_passes = 6;  ///< where it does not settle sooner
  int passes = 3;       ///< between them noises are taken from the residuals, outliers lose
  int iterations = 15;  ///< of each pass, at most
  int threads = 1;
  double cluster = 4.0;  ///< residuals further apart are independent [s]
  std::function<void(const std::string&)> progress;  ///< a line now and then
};

/// How well a source fits at the end.
struct SourceFit {
  std::string name;
  std::size_t count = 0;
  double stated = 0.0;  ///< what was said of its noise
  double found = 0.0;   ///< what the residuals have, robustly
};

/// How the drive turns, by the states at the windows' ends.
struct Turns {
  /// How little the lateral acceleration goes with the curvature: 0 at one speed, 0.46 on the
  /// exercise that the help asks for.
  //
  // With κ = ψ̇ / v, a = v ψ̇ and a_0 = κ Σ a κ / Σ κ²:  sqrt(Σ (a - a_0)² / Σ a²). On a circle the
  // bicycle has δ = l κ + (m l_h / C_v - m l_v / C_h) a / l: without variety, the steering's scale
  // and the tyres are one number.
  double speed_variety = 0.0;
  double hard = 0.0;     ///< share of the time beyond a half of the grip of dry tyres, 0.5 g
  double hardest = 0.0;  ///< lateral acceleration that is passed in a twentieth of the time [m/s²]
};

struct Result {
  Numbers<double> p{};
  Numbers<double> sigma{};         ///< standard uncertainties of p; 0 of what was fixed
  Numbers<double> naive{};         ///< the same, if all residuals were independent
  Eigen::MatrixXd covariance;      ///< of all p, fixed ones 0
  std::vector<SourceFit> sources;  ///< by estimator::Source; the camera's: x and y, then yaw
  std::vector<ResidualPoint> residuals;
  int iterations = 0;
  bool settled = false;  ///< or given up
  double cost = 0.0;
  Turns turns;
};

/// Throws std::runtime_error where the solver does not come to an end.
[[nodiscard]] Result solve(const daemon::Config& config, std::span<const Drive> drives,
                           const Settings& settings);

}  // namespace odomd::tools::fitting
