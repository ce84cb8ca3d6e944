// Fits all parameters at once: those with which a single-track car, driven by the measured
// steering, matches sensors and poses best, by nonlinear least squares.
//
// Multiple shooting: the drive is cut into windows; in each the model runs from a free state, and
// its end must meet the start of the next within the model's uncertainty. The acceleration along x
// is a free function, linear between knots; v_x is its integral.
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
  Numbers<double> prior_sigma{};  ///< standard deviations of p beforehand
  std::optional<Measured> rest;   ///< the gyro's bias as it shows at rest [rad/s]
  double window = 0.5;            ///< [s]
  int passes = 3;  ///< at least; between them noise is taken from the residuals, outliers lose
  int threads = 1;
  std::function<void(const std::string&)> progress;  ///< called with a line now and then

  [[nodiscard]] std::vector<std::size_t> free_ones() const;
  /// The prior of p: its value and standard deviation.
  [[nodiscard]] Measured known(std::size_t k) const;
};

/// The fit of a source at the end.
struct SourceFit {
  std::string name;
  std::size_t count = 0;
  double stated = 0.0;  ///< its stated noise
  double found = 0.0;   ///< noise of the residuals, robust
};

struct Result {
  Numbers<double> p{};
  Numbers<double> sigma{};         ///< standard uncertainties of p; 0 for fixed ones
  Numbers<double> naive{};         ///< the same, if all residuals were independent
  Eigen::MatrixXd covariance;      ///< of all p, fixed ones 0
  std::vector<SourceFit> sources;  ///< by estimator::Source; the camera's: x and y, then yaw
  std::vector<ResidualPoint> residuals;
  int iterations = 0;
  bool settled = false;  ///< or stopped
  Turns turns;
};

/// Throws std::invalid_argument for a drive that shows nothing, and where no parameter is free,
/// std::runtime_error if the solver fails.
[[nodiscard]] Result solve(const daemon::Config& config, std::span<const Drive> drives,
                           const Settings& settings);

}  // namespace odomd::tools::fitting
