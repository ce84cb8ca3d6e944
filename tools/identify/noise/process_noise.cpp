#include "tools/identify/noise/noise_findings.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <optional>
#include <span>

#include "tools/evaluation/drive_evaluation.hpp"
#include "tools/identify/common/measured.hpp"
#include "tools/identify/common/search.hpp"
#include "tools/identify/common/signal_log.hpp"

namespace odomd::tools {
namespace {

using estimator::Source;

constexpr std::size_t blocks = 20;
constexpr double wild =
    16.0;  ///< limit of a squared ratio, so that one outlier does not outweigh a thousand samples

constexpr int usual_replays = 45;

/// Blocks of the drive are nearly independent: the scatter of their means gives the uncertainty.
std::vector<SourceConsistency> consistency(const std::vector<estimator::Judgement>& judgements) {
  std::vector<SourceConsistency> all;
  for (std::size_t s = 0; s < estimator::source_count; ++s) {
    std::vector<double> ratios;
    for (const estimator::Judgement& judgement : judgements) {
      if (judgement.source != static_cast<Source>(s) || judgement.degrees == 0) continue;
      ratios.push_back(std::min(judgement.squared_ratio / judgement.degrees, wild));
    }
    if (ratios.size() < 5 * blocks) continue;
    std::array<double, blocks> means{};
    for (std::size_t k = 0; k < blocks; ++k) {
      const std::size_t begin = k * ratios.size() / blocks, end = (k + 1) * ratios.size() / blocks;
      means[k] = mean_of(std::span(ratios).subspan(begin, end - begin)).value;
    }
    all.push_back({static_cast<Source>(s),
                   static_cast<double>(ratios.size()),
                   {mean_of(ratios).value, mean_of(means).sigma}});
  }
  return all;
}

std::optional<Measured> nis_of(const std::vector<SourceConsistency>& all, Source source) {
  const auto found = std::ranges::find(all, source, &SourceConsistency::source);
  return found == all.end() ? std::nullopt : std::optional(found->nis);
}

class Search {
 public:
  Search(const Drive& drive, daemon::Config& config, const ReportProgress& report)
      : drive_(drive), config_(config), report_(report) {}

  [[nodiscard]] std::vector<SourceConsistency> replay() {
    ++replays_;
    if (report_)
      report_("replay " + std::to_string(replays_) + " of about " + std::to_string(usual_replays));
    judgements_ = replay_drive(drive_, config_, Frame::map, Judgements::keep).judgements;
    return consistency(judgements_);
  }

  /// Finds the R for which the mean of ν²/S is 1, with S = H P Hᵀ + R; repeated, as P depends on R.
  /// R is at least the sensor's own noise as configured.
  std::vector<SampleNoise> settle_wheels() {
    const daemon::Config given = config_;
    std::vector<SampleNoise> found;
    for (int round = 0; round < 4; ++round) {
      const std::vector<SourceConsistency> all = replay();
      found.clear();
      for (const Source wheel : wheel_sources) {
        const auto nis = nis_of(all, wheel);
        const auto index = static_cast<std::size_t>(wheel);
        double& sigma = config_.can.signals[index].sigma;
        const double least = given.can.signals[index].sigma;
        if (!nis || !(least > 0.0)) continue;
        const double variance = settled_variance(wheel, sigma * sigma, least * least);
        const double slope = -mean_with(wheel, variance - sigma * sigma, 2.0);
        sigma = std::sqrt(variance);
        found.push_back({wheel, {sigma, 0.5 * nis->sigma / std::fabs(slope) / sigma}});
      }
    }
    return found;
  }

  /// Adjusts a setting until the NIS of a source is 1; false if no value does that.
  bool settle(double& setting, Source source, Finding& finding) {
    constexpr double tolerance = 0.02;
    const double start = setting;
    double low = std::log(start / 30.0), high = std::log(start * 30.0);
    double x = std::log(start), last_x = x, last_y = 0.0, slope = -0.5;
    for (int i = 0; i < 12; ++i) {
      setting = std::exp(x);
      const auto nis = nis_of(replay(), source);
      if (!nis) return give_up(finding, "the drive has too few samples of its sensor");
      const double y = std::log(nis->value);
      // The innovations decrease, relative to their expected size, as the noise grows.
      if (i > 0 && std::fabs(x - last_x) > 1e-3)
        slope = std::clamp((y - last_y) / (x - last_x), -2.0, -0.02);
      finding.value = setting;
      finding.sigma = setting * std::hypot(nis->sigma / nis->value, tolerance) / std::fabs(slope);
      if (std::fabs(y) < tolerance) break;
      (y > 0.0 ? low : high) = x;
      last_x = x;
      last_y = y;
      const double wanted = x - y / slope;
      x = wanted > low && wanted < high ? wanted : 0.5 * (low + high);
      if (high - low < 0.02) break;
    }
    if (finding.value < start / 25.0)
      return give_up(finding,
                     "even with the smallest value the filter expects larger innovations: the "
                     "value given is on the safe side");
    if (finding.value > start * 25.0)
      return give_up(finding,
                     "no noise explains the innovations; is a signal's sign, scale or "
                     "latency wrong?");
    if (finding.sigma > finding.value)
      return give_up(finding, "the innovations hardly depend on it; drive harder turns");
    finding.determined = Determined::yes;
    return true;
  }

 private:
  /// Mean of ν²/(S + more)^power over a source's samples in the last replay.
  [[nodiscard]] double mean_with(Source source, double more, double power) const {
    double sum = 0.0, count = 0.0;
    for (const estimator::Judgement& judgement : judgements_) {
      if (judgement.source != source || judgement.degrees == 0) continue;
      const double s = judgement.variance[0];
      const double square = std::min(judgement.innovation[0] * judgement.innovation[0], wild * s);
      sum += square / std::pow(s + more, power);
      count += 1.0;
    }
    return count > 0.0 ? sum / count : 0.0;
  }

  [[nodiscard]] double settled_variance(Source source, double now, double least) const {
    const auto is_before = [&](double variance) {
      return mean_with(source, variance - now, 1.0) > 1.0;
    };
    if (!is_before(least)) return least;
    const double begin = std::log(least), end = std::log(1e4 * least);
    return std::exp(bisect({begin, end}, 50, [&](double log_variance) {
                      return is_before(std::exp(log_variance));
                    }).middle());
  }

  static bool give_up(Finding& finding, const std::string& why) {
    finding = undetermined(std::move(finding), why);
    return false;
  }

  const Drive& drive_;
  daemon::Config& config_;
  std::vector<estimator::Judgement> judgements_;  // from the last replay
  const ReportProgress& report_;
  int replays_ = 0;
};

}  // namespace

ProcessNoise process_noise(const Drive& drive, daemon::Config config,
                           const ReportProgress& report) {
  config.model = estimator::Model::full;
  ProcessNoise result;
  result.front_angle = as_finding("front angle error", "filter.front_angle_error", {}, "rad",
                                  "by the gyro's innovations");
  result.side_slip = as_finding("side slip error", "filter.side_slip_error", {}, "",
                                "by the innovations of accel_y");
  Search search(drive, config, report);
  result.before = search.replay();
  result.wheels = search.settle_wheels();
  const estimator::Tuning given = config.tuning;
  // Each setting affects the other's innovations a little.
  for (int round = 0; round < 2; ++round) {
    if (!search.settle(config.tuning.front_angle, Source::yaw_rate, result.front_angle))
      config.tuning.front_angle = given.front_angle;
    if (!search.settle(config.tuning.side_slip, Source::accel_y, result.side_slip))
      config.tuning.side_slip = given.side_slip;
  }
  result.after = search.replay();
  return result;
}

}  // namespace odomd::tools
