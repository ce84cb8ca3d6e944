#include "tools/identify/common/agreement.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <optional>
#include <stdexcept>
#include <string>
#include <utility>
#include <vector>

#include "daemon/core/comparison.hpp"
#include "tools/cli/text.hpp"
#include "tools/diagnostics/kinds.hpp"
#include "tools/drive_files/trajectory.hpp"
#include "tools/identify/common/signal_log.hpp"
#include "tools/math/median.hpp"
#include "tools/replay/replay_checks.hpp"

namespace odomd::tools {
namespace {

using diagnostics::Diagnostic;
using diagnostics::found;
using estimator::Source;

constexpr double piece = 0.5, max_piece = 0.85, usual_stride = 0.25, grid = 0.01;  // [s]
constexpr double lag_step = 0.02;                                                  // [s]
constexpr int max_lag = 20, max_late_lag = 75;  // steps: of a usual sensor, of a very late one
constexpr double max_latency = 0.15;            // more than the latency of any sensor [s]
constexpr double min_turn = 0.05;               // rad per piece, rms
constexpr double min_distance = 0.1;            // m per piece
constexpr std::ptrdiff_t min_pieces = 20;
constexpr double related = 0.5, clearly_related = 0.7;  // correlations
constexpr double max_unseen_ratio = 3.0;                // without poses: wheels and tyres may slip

enum class Match : std::uint8_t { unknown, same, opposite, unrelated };

struct Comparison {
  Match match = Match::unknown;
  double ratio = 1.0;  ///< `turned` / pieces, if they agree
  double lag = 0.0;    ///< delay of `turned` [s]; 0 if unknown
};

/// Correlations over all lags.
struct Range {
  double lowest = 1.0, highest = -1.0;

  void add(double correlation) {
    lowest = std::min(lowest, correlation);
    highest = std::max(highest, correlation);
  }
};

// The turns show whether both signs agree. Without their mean, they show whether both signals turn
// at the same times.
Comparison compare(const std::vector<Piece>& pieces, const Resampled& turned, double min_rms) {
  Range late, turns, variations;
  double ratio = 1.0, best_lag = 0.0;
  bool is_turning = false, is_varying = false;
  for (int step = -max_late_lag; step <= max_late_lag; ++step) {
    const double lag = lag_step * step;
    std::vector<std::pair<double, double>> both;  // turn of the piece, turn of the sensor
    double squares = 0.0;
    for (const Piece& p : pieces) {
      if (p.from + lag < turned.begin || p.to + lag > turned.end()) continue;
      both.emplace_back(p.turn, turned.at(p.to + lag) - turned.at(p.from + lag));
      squares += both.back().second * both.back().second;
    }
    if (std::ssize(both) < min_pieces) continue;
    // A single pose with reversed heading must not outweigh the drive.
    const auto count = static_cast<double>(both.size());
    const double bound = std::max(3.0 * std::sqrt(squares / count), 6.0 * min_rms);
    daemon::Moments moments;
    for (const auto& [seen, by_sensor] : both)
      moments.add(std::clamp(seen, -bound, bound), by_sensor);
    const daemon::Moments::Squares about_zero = moments.squares(0.0, 0.0);
    const daemon::Moments::Squares about_mean = moments.squares();
    const double whole = about_zero.correlation(), varying = about_mean.correlation();
    late.add(whole);
    if (std::abs(step) > max_lag) continue;
    if (whole > turns.highest && about_zero.aa > 0.0)
      ratio = std::sqrt(about_zero.bb / about_zero.aa);
    if (varying > variations.highest) best_lag = lag;
    turns.add(whole);
    variations.add(varying);
    const auto exceeds = [min_rms](double square, double whole_square) {
      return square > std::max(min_rms * min_rms, 0.09 * whole_square);
    };
    is_turning = is_turning || std::max(about_zero.aa, about_zero.bb) > min_rms * min_rms;
    is_varying = is_varying || exceeds(about_mean.aa, about_zero.aa) ||
                 exceeds(about_mean.bb, about_zero.bb);
  }
  if (!is_turning) return {};
  // The opposite sign must fit better than any delay.
  if (turns.lowest < -clearly_related && turns.highest < related && late.highest < -turns.lowest &&
      (!is_varying || variations.lowest < -clearly_related))
    return {Match::opposite};
  if (is_varying && variations.highest < related) return {Match::unrelated};
  if (!(turns.highest > clearly_related)) return {};
  return {Match::same, ratio, is_varying && variations.highest > clearly_related ? best_lag : 0.0};
}

std::vector<Piece> pieces_of(const Resampled& turned) {
  std::vector<Piece> result = even_pieces(turned.begin, turned.end(), usual_stride);
  for (Piece& p : result) p.turn = turned.at(p.to) - turned.at(p.from);
  return result;
}

class Signals {
 public:
  Signals(const daemon::Config& config, const SignalLog& log, const AgreementOptions& options)
      : config_(config), log_(log) {
    const Series& gyro = log.of(Source::yaw_rate);
    if (gyro.size() < 2) return;
    begin_ = std::max(options.from, log.seconds(gyro.t_ns.front()));
    end_ = std::min(options.to, log.seconds(gyro.t_ns.back()));
  }

  [[nodiscard]] double begin() const { return begin_; }
  [[nodiscard]] double end() const { return end_; }
  [[nodiscard]] Resampled on_grid(const Series& series) const {
    return resampled(series, log_.first_ns, begin_, end_, grid);
  }

  // The speed, negative in reverse gear.
  [[nodiscard]] Resampled speed(Source wheel) const {
    return on_grid(with_direction(log_.of(wheel), log_.of(Source::direction)));
  }
  [[nodiscard]] std::optional<Resampled> speed() const {
    for (const Source wheel : speed_sources)
      if (log_.has(wheel)) return speed(wheel);
    return std::nullopt;
  }

  // ∫ v tan δ / l: tyres do not change the sign of the turn.
  [[nodiscard]] std::optional<Resampled> steered() const {
    const std::optional<Resampled> rolled = speed();
    if (!rolled || !log_.has(Source::steering)) return std::nullopt;
    return integral(
        combined(*rolled, on_grid(log_.of(Source::steering)), [this](double v, double delta) {
          return v * std::tan(std::clamp(delta, -1.0, 1.0)) / config_.vehicle.wheelbase();
        }));
  }

  // The motion as a trajectory, with the distance as x and the turn as yaw.
  [[nodiscard]] Trajectory driven() const {
    const Resampled turned = integral(on_grid(log_.of(Source::yaw_rate)));
    const std::optional<Resampled> rolled = speed();
    const Resampled distance = rolled ? integral(*rolled) : Resampled{};
    Trajectory result;
    constexpr std::size_t every = 5;
    for (std::size_t k = 0; k < turned.value.size(); k += every) {
      const double t = turned.begin + turned.step * static_cast<double>(k);
      result.points.push_back({.t_ns = log_.first_ns + std::llround(1e9 * t),
                               .pose = {rolled ? distance.at(t) : 0.0, 0.0, turned.value[k]}});
    }
    return result;
  }

 private:
  const daemon::Config& config_;
  const SignalLog& log_;
  double begin_ = 0.0, end_ = 0.0;
};

// Distance of a wheel / that of the poses, median of the pieces; empty if too little was driven.
std::optional<double> distance_ratio(const std::vector<Piece>& pieces, const Resampled& speed,
                                     double min_along) {
  const Resampled distance = integral(speed);
  std::vector<double> ratios;
  for (const Piece& p : pieces)
    if (std::fabs(p.along) >= min_along && p.from >= distance.begin && p.to <= distance.end())
      ratios.push_back((distance.at(p.to) - distance.at(p.from)) / p.along);
  if (std::ssize(ratios) < min_pieces) return std::nullopt;
  return median_of(std::move(ratios));
}

}  // namespace

Relation relation_of(const Eigen::Ref<const Eigen::ArrayXd>& y,
                     const Eigen::Ref<const Eigen::ArrayXd>& x) {
  if (y.size() < 2) return {};
  daemon::Moments moments;  // from the first values, so that a constant has no variance
  for (Eigen::Index i = 0; i < y.size(); ++i) moments.add(y[i] - y[0], x[i] - x[0]);
  const daemon::Moments::Squares squares = moments.squares();
  if (squares.bb <= 0.0) return {.count = static_cast<std::size_t>(y.size())};
  const double slope = squares.ab / squares.bb;
  return {.slope = slope,
          .offset = y[0] + moments.mean_a() - slope * (x[0] + moments.mean_b()),
          .correlation = squares.correlation(),
          .gain = squares.gain(),
          .count = static_cast<std::size_t>(y.size())};
}

std::vector<Piece> pieces_of(std::span<const PoseSample> poses, double stride, double longest,
                             const std::array<double, 3>& lever_arm) {
  constexpr double jitter = 1e-3;  // s
  std::vector<Piece> result;
  for (std::size_t i = 0, j = 0; i < poses.size(); ++i) {
    const PoseSample& from = poses[i];
    if (!result.empty() && from.t < result.back().from + stride - jitter) continue;
    while (j < poses.size() && poses[j].t < from.t + piece - jitter) ++j;
    if (j == poses.size()) break;
    const PoseSample& to = poses[j];
    if (to.t - from.t > longest) continue;
    const double turn = std::remainder(to.yaw - from.yaw, 2.0 * std::numbers::pi);
    const double heading = from.yaw + 0.5 * turn - lever_arm[2];
    // A point on the left of the centre is slower in a turn to the left.
    result.push_back({from.t, to.t, turn,
                      (to.x - from.x) * std::cos(heading) + (to.y - from.y) * std::sin(heading) +
                          lever_arm[1] * turn});
  }
  return result;
}

std::vector<Piece> even_pieces(double begin, double end, double stride) {
  std::vector<Piece> result;
  for (int k = 0; begin + stride * k + piece <= end; ++k)
    result.push_back({begin + stride * k, begin + stride * k + piece});
  return result;
}

std::optional<Diagnostic> find_disagreement(const daemon::Config& config, const SignalLog& log,
                                            std::span<const estimator::CameraPose> poses,
                                            const AgreementOptions& options) {
  const std::string& source = options.pose_source;
  const std::string poses_of = "the " + source;
  if (!poses.empty() && std::ranges::none_of(poses, [&](const estimator::CameraPose& pose) {
        return pose.capture_ns >= log.first_ns && pose.capture_ns <= log.last_ns;
      }))
    return found(kind("camera_outside_log"), source,
                 "no " + source + " pose is taken while the log lasts");
  const Signals signals(config, log, options);
  if (!(signals.end() - signals.begin() > 1.0)) return std::nullopt;

  const Resampled turned = integral(signals.on_grid(log.of(Source::yaw_rate)));
  const std::optional<Resampled> steered = signals.steered();
  const Comparison gyro_to_steering =
      steered ? compare(pieces_of(turned), *steered, min_turn) : Comparison{};
  const auto wrong_sign = [](Source sensor, const std::string& others) {
    return found(kind("wrong_sign"), name_of(sensor), "turns the other way than " + others,
                 key_of(sensor));
  };
  if (poses.empty()) {
    if (gyro_to_steering.match == Match::opposite)
      return found(kind("wrong_sign"), name_of(Source::yaw_rate),
                   "turns the other way than wheels and steering",
                   key_of(Source::yaw_rate) + ".scale and " + key_of(Source::steering));
    if (!steered) return std::nullopt;
    // Compares in both directions: compare() limits large pieces, which hides small ratios.
    const double far = compare(pieces_of(*steered), turned, min_turn).ratio;
    const double little = gyro_to_steering.ratio;
    if (std::max(far, little) <= max_unseen_ratio) return std::nullopt;
    return found(kind("scale_off"), name_of(Source::yaw_rate),
                 "turns " + fixed(std::max(far, little), 1) + " times as " +
                     (far > little ? "far" : "little") + " as wheels and steering say",
                 "yaw_rate, steering and the wheels");
  }

  if (const auto units =
          check_units(poses_of + "'s poses", poses, {.trajectory = signals.driven()});
      !units.empty())
    return units.front();

  std::vector<Piece> seen =
      pieces_of(in_order(poses, log.first_ns), usual_stride, max_piece, config.camera.lever_arm);
  std::erase_if(seen,
                [&](const Piece& p) { return p.from < signals.begin() || p.to > signals.end(); });
  const auto scale_limits = kind("scale_off").limits;
  std::vector<double> yaw_sigmas, sigmas;
  for (const estimator::CameraPose& pose : poses) {
    yaw_sigmas.push_back(pose.sigma_yaw);
    sigmas.push_back(std::max(pose.sigma_x, pose.sigma_y));
  }
  const double min_rms = std::max(min_turn, 4.0 * median_of(std::move(yaw_sigmas)));
  const Comparison gyro = compare(seen, turned, min_rms);
  if (gyro.match == Match::opposite) {
    if (gyro_to_steering.match == Match::same)
      return found(kind("camera_mirrored"), source,
                   "turns the other way than yaw_rate and steering: is its file from this drive?");
    return wrong_sign(Source::yaw_rate, poses_of);
  }
  if (gyro.match == Match::unrelated) {
    if (options.unrelated == UnrelatedPoses::accept) return std::nullopt;
    return found(kind("camera_turns_unrelated"), source,
                 "its turns and those of yaw_rate have nothing in common");
  }
  if (options.unrelated == UnrelatedPoses::refuse && std::fabs(gyro.lag) > max_latency)
    return found(kind("clocks_differ"), source,
                 "the times of its poses are " + fixed(std::fabs(gyro.lag), 1) +
                     (std::fabs(gyro.lag) < (max_lag - 0.5) * lag_step ? " s " : " s or more ") +
                     (gyro.lag < 0.0 ? "late" : "early") + " compared with yaw_rate");
  if (gyro.match == Match::same && !scale_limits.hold(gyro.ratio))
    return found(kind("scale_off"), name_of(Source::yaw_rate),
                 "turns " + fixed(gyro.ratio, 2) + " times as far as " + poses_of,
                 key_of(Source::yaw_rate));

  for (const Source wheel : wheel_sources) {
    if (!log.has(wheel)) continue;
    const auto ratio =
        distance_ratio(seen, signals.speed(wheel), std::max(min_distance, 6.0 * median_of(sigmas)));
    if (ratio && *ratio < 0.0)
      return found(kind("runs_backwards"), name_of(wheel),
                   "runs backwards where " + poses_of + " sees the car go ahead", key_of(wheel));
    if (ratio && !scale_limits.hold(*ratio))
      return found(kind("scale_off"), name_of(wheel),
                   "is " + fixed(*ratio, 2) + " times as fast as " + poses_of + " sees the car",
                   key_of(wheel));
  }

  if (!steered) return std::nullopt;
  const Comparison steering = compare(seen, *steered, min_rms);
  const bool by_gyro = gyro.match == Match::same && gyro_to_steering.match == Match::opposite;
  if (steering.match == Match::opposite || by_gyro)
    return wrong_sign(Source::steering, poses_of + " and yaw_rate");
  return std::nullopt;
}

void check_agreement(const daemon::Config& config, const SignalLog& log,
                     std::span<const estimator::CameraPose> poses,
                     const AgreementOptions& options) {
  if (const auto wrong = find_disagreement(config, log, poses, options))
    throw std::invalid_argument((options.drive.empty() ? "" : options.drive + ": ") +
                                text_of(*wrong));
}

}  // namespace odomd::tools
