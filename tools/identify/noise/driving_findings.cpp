// The findings of a drive.
#include <Eigen/Cholesky>
#include <Eigen/Core>
#include <algorithm>
#include <cmath>
#include <string>
#include <vector>

#include "tools/cli/progress.hpp"
#include "tools/identify/common/agreement.hpp"
#include "tools/identify/common/refuse.hpp"
#include "tools/identify/noise/noise_findings.hpp"
#include "tools/math/median.hpp"

namespace odomd::tools {
namespace {

using estimator::Source;

constexpr Eigen::Index lags = 7, most_blocks = 24;
using Covariances = Eigen::Array<double, lags, 1>;

// Autocovariances of third differences, coefficients 1 -3 3 -1: the first column is for white noise
// of variance 1, the second for differences of such noise (an encoder's rounding errors, each of
// which counts twice).
const Eigen::Matrix<double, lags, 2> design{{20.0, 70.0}, {-15.0, -56.0}, {6.0, 28.0}, {-1.0, -8.0},
                                            {0.0, 1.0},   {0.0, 0.0},     {0.0, 0.0}};

/// The variances of the two parts for which the covariances fit best; neither is negative.
Eigen::Vector2d explain(const Covariances& covariance) {
  const Eigen::Vector2d seen = design.transpose() * covariance.matrix();
  const Eigen::Matrix2d normal = design.transpose() * design;
  const Eigen::Vector2d both = normal.ldlt().solve(seen);
  if (both[1] < 0.0) return {std::max(seen[0] / normal(0, 0), 0.0), 0.0};
  if (both[0] < 0.0) return {0.0, std::max(seen[1] / normal(1, 1), 0.0)};
  return both;
}

/// Sigmas of the whole noise, of its white part, and of its increments.
Eigen::Array3d sigmas_of(const Covariances& covariance) {
  const Eigen::Vector2d part = explain(covariance);
  // Each rounding error of an increment is in two samples.
  return Eigen::Array3d{part[0] + 2.0 * part[1], part[0], 2.0 * part[1]}.sqrt();
}

/// Third differences; NaN if the four samples are not consecutive.
std::vector<double> third_differences(const Series& series) {
  std::vector<std::int64_t> steps;
  for (std::size_t i = 1; i < series.size(); ++i)
    steps.push_back(series.t_ns[i] - series.t_ns[i - 1]);
  const std::int64_t usual = median_of(steps);
  const std::vector<double>& y = series.value;
  std::vector<double> third;
  for (std::size_t i = 0; i + 3 < series.size(); ++i) {
    bool even = y[i] != 0.0;
    for (std::size_t k = i; k < i + 3; ++k)
      even = even && y[k + 1] != 0.0 && steps[k] > usual / 2 && steps[k] < usual + usual / 2;
    third.push_back(even ? y[i + 3] - 3.0 * y[i + 2] + 3.0 * y[i + 1] - y[i] : std::nan(""));
  }
  return third;
}

void add_consistency(const char* when, const std::vector<SourceConsistency>& all,
                     Findings& findings) {
  for (const SourceConsistency& one : all)
    findings.details["nis"][when][name_of(one.source)] = {
        {"samples", one.samples}, {"mean", one.nis.value}, {"sigma", one.nis.sigma}};
}

// 0.5 to 2 is acceptable; the filter expects 1.
std::string in_words(double nis) {
  if (nis > 2.0) return "much larger than expected: the filter trusts this source too much";
  if (nis > 1.25) return "larger than expected, by a factor below 2";
  if (nis >= 0.8) return "as expected";
  if (nis >= 0.5) return "smaller than expected, by a factor below 2";
  return "much smaller than expected: the filter trusts this source too little";
}

}  // namespace

DrivingNoise driving_noise(const Series& series) {
  DrivingNoise noise;
  if (series.size() < 200) return noise;
  const std::vector<double> third = third_differences(series);
  // Nearly independent blocks: their scatter gives the uncertainty.
  Eigen::Array<double, lags, most_blocks> sums, counts;
  sums.setZero();
  counts.setZero();
  for (std::size_t i = 0; i < third.size(); ++i) {
    if (std::isnan(third[i])) continue;
    const auto block = static_cast<Eigen::Index>(i * most_blocks / third.size());
    for (std::size_t k = 0; k < lags && i + k < third.size(); ++k) {
      if (std::isnan(third[i + k])) continue;
      sums(static_cast<Eigen::Index>(k), block) += third[i] * third[i + k];
      counts(static_cast<Eigen::Index>(k), block) += 1.0;
    }
    noise.samples += 1.0;
  }
  std::vector<Eigen::Index> blocks;
  for (Eigen::Index block = 0; block < most_blocks; ++block)
    if (counts(lags - 1, block) >= 5.0) blocks.push_back(block);
  if (noise.samples < 100.0 || blocks.size() < 8) {
    noise.samples = 0.0;
    return noise;
  }
  const Covariances sum = sums(Eigen::all, blocks).rowwise().sum();
  const Covariances count = counts(Eigen::all, blocks).rowwise().sum();
  const Covariances whole = sum / count;
  const Eigen::Array3d found = sigmas_of(whole);
  // Jackknife
  Eigen::Array3d squares = Eigen::Array3d::Zero();
  for (const Eigen::Index block : blocks)
    squares += (sigmas_of((sum - sums.col(block)) / (count - counts.col(block))) - found).square();
  const auto n = static_cast<double>(blocks.size());
  const Eigen::Array3d sigma = ((n - 1.0) / n * squares).sqrt();
  noise.sigma = {found[0], sigma[0]};
  noise.white = {found[1], sigma[1]};
  noise.increments = {found[2], sigma[2]};
  const Covariances left = whole - (design * explain(whole)).array();
  noise.smooth = left.abs().maxCoeff() < 0.15 * whole[0];
  return noise;
}

void add_driving_findings(const DriveFiles& files, const std::optional<daemon::Config>& config,
                          Findings& findings) {
  Drive drive = read_drive(files);
  append(findings.warnings, drive.warnings);
  const std::vector<std::string> logs{need_log_in(drive.folder).string()};
  const SignalLog log = read_signals(drive.config, logs);
  if (wheels_stand(log, 0.1))
    refuse(
        "{}: no wheel turns faster than 0.1 m/s; --drive needs a moving car, --config and --can a "
        "standing one",
        drive.folder.string());
  // Noise must not compensate for a wrong sign.
  check_agreement(drive.config, log, drive.cameras, {.drive = drive.folder.string()});
  const auto measure = [&](Source source, const std::string& unit) {
    const DrivingNoise noise = driving_noise(log.of(source));
    if (noise.samples == 0.0) return;
    const std::string key = key_of(source, ".sigma");
    Finding finding =
        as_finding(name_of(source) + ", noise on the move", key_if_mapped(config, source, key),
                   noise.sigma, unit, "of a sample, including the car's vibration");
    if (!noise.smooth)
      finding = undetermined(
          finding,
          "the car moves too fast for the sample rate; use faster samples, or a gentler drive");
    findings.details["on_the_move"][name_of(source)] = {
        {"sigma", noise.sigma.value},
        {"white", noise.white.value},
        {"white_sigma", noise.white.sigma},
        {"increments", noise.increments.value},
        {"increments_sigma", noise.increments.sigma}};
    if (finding.determined == Determined::yes) {
      // The filter needs the larger of the noises at rest and while driving.
      for (Finding& at_rest : findings.values)
        if (at_rest.key == key) at_rest.key.clear();
      drive.config.can.signals[static_cast<std::size_t>(source)].sigma = noise.sigma.value;
    }
    findings.values.push_back(finding);
    if (source == Source::yaw_rate && finding.determined == Determined::yes)
      add_paper_variance(noise.sigma, config, findings);
  };
  for (const InertialSource& quantity : inertial_sources) measure(quantity.source, quantity.unit);
  for (const Source wheel : wheel_sources) measure(wheel, "m/s");

  ProgressLine progress("odom identify noise");
  const ProcessNoise process = process_noise(
      drive, drive.config, [&progress](const std::string& now) { progress.show(now); });
  progress.end();
  for (const SampleNoise& wheel : process.wheels) {
    const std::string key = key_of(wheel.source, ".sigma");
    for (Finding& other : findings.values)
      if (other.key == key) other.key.clear();
    findings.values.push_back(as_finding(name_of(wheel.source) + ", sigma for the filter",
                                         key_if_mapped(config, wheel.source, key), wheel.sigma,
                                         "m/s", "by its innovations, including slip"));
  }
  findings.values.push_back(process.front_angle);
  findings.values.push_back(process.side_slip);
  add_consistency("before", process.before, findings);
  add_consistency("after", process.after, findings);
  for (const SourceConsistency& one : process.after)
    findings.values.push_back(
        as_finding(name_of(one.source) + ", mean NIS", "", one.nis, "", in_words(one.nis.value)));
}

}  // namespace odomd::tools
