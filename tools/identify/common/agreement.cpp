#include "tools/identify/common/agreement.hpp"

#include <Eigen/Core>
#include <algorithm>
#include <cmath>
#include <numbers>
#include <optional>
#include <stdexcept>
#include <string>
#include <utility>
#include <vector>

#include "daemon/diagnostics/diagnostic.hpp"
#include "tools/cli/text.hpp"
#include "tools/diagnostics/unit_check.hpp"
#include "tools/drive_files/trajectory.hpp"
#include "tools/identify/common/resampled.hpp"
#include "tools/math/median.hpp"

namespace odomd::tools {
namespace {

using diagnostics::Diagnostic;
using diagnostics::found;
using diagnostics::kind;
using Eigen::ArrayXd;
using estimator::Source;

constexpr double piece = 0.5, stride = 0.25, grid = 0.01, lag_step = 0.02;  // [s]
constexpr int latest = 20, latest_of_all = 75;  // steps, for a usual sensor and a very late one
constexpr double off_clock = 0.15;              // more than the latency of any sensor [s]
constexpr double least_turn = 0.05;             // rad per piece, rms
constexpr double least_way = 0.1;               // m per piece
constexpr std::ptrdiff_t fewest = 20;           // pieces
constexpr double alike = 0.5, certain = 0.7;    // correlations
constexpr double far_off_unseen = 3.0;  // without poses: allows for slipping wheels and tyres

// The motion in a piece of the drive.
struct Piece {
  double t = 0.0;      ///< start of the piece [s]
  double turn = 0.0;   ///< [rad]
  double along = 0.0;  ///< distance along the heading [m]; from poses only
};

enum class Verdict : std::uint8_t { silent, same, other_way, unlike };

struct Comparison {
  Verdict verdict = Verdict::silent;
  double ratio = 1.0;  ///< `turned` / pieces, if they agree
  double lag = 0.0;    ///< delay of `turned` [s]; 0 if unknown
};

double rms(const ArrayXd& values) {
  return values.size() > 0 ? std::sqrt(values.square().mean()) : 0.0;
}

// a·b / (|a| |b|)
double cosine(const ArrayXd& a, const ArrayXd& b) {
  const double both = rms(a) * rms(b);
  return both > 0.0 ? (a * b).mean() / both : 0.0;
}

// Turns show the sign; less their means they show whether both signals turn at the same times.
Comparison compare(const std::vector<Piece>& pieces, const Resampled& turned, double least) {
  double most = -1.0, fewest_alike = 1.0, most_shape = -1.0, least_shape = 1.0, ratio = 1.0;
  double best_lag = 0.0, most_of_all = -1.0;
  bool turns = false, varies = false;
  for (int step = -latest_of_all; step <= latest_of_all; ++step) {
    const double lag = lag_step * step;
    ArrayXd seen(std::ssize(pieces)), by_sensor(std::ssize(pieces));
    Eigen::Index count = 0;
    for (const Piece& p : pieces) {
      const double begin = p.t + lag, end = begin + piece;
      if (begin < turned.begin || end > turned.end()) continue;
      seen[count] = p.turn;
      by_sensor[count++] = turned.at(end) - turned.at(begin);
    }
    if (count < fewest) continue;
    by_sensor.conservativeResize(count);
    // A single pose with reversed heading must not outweigh the drive.
    const double bound = std::max(3.0 * rms(by_sensor), 6.0 * least);
    seen = seen.head(count).max(-bound).min(bound).eval();
    const double whole = cosine(seen, by_sensor);
    most_of_all = std::max(most_of_all, whole);
    if (std::abs(step) > latest) continue;
    if (whole > most && rms(seen) > 0.0) ratio = rms(by_sensor) / rms(seen);
    most = std::max(most, whole);
    fewest_alike = std::min(fewest_alike, whole);
    const ArrayXd a = seen - seen.mean(), b = by_sensor - by_sensor.mean();
    const double shape = cosine(a, b);
    if (shape > most_shape) best_lag = lag;
    most_shape = std::max(most_shape, shape);
    least_shape = std::min(least_shape, shape);
    turns = turns || std::max(rms(seen), rms(by_sensor)) > least;
    varies = varies || (rms(a) > std::max(least, 0.3 * rms(seen))) ||
             (rms(b) > std::max(least, 0.3 * rms(by_sensor)));
  }
  if (!turns) return {};
  // The opposite sign must fit better than any delay.
  if (fewest_alike < -certain && most < alike && most_of_all < -fewest_alike &&
      (!varies || least_shape < -certain))
    return {Verdict::other_way};
  if (varies && most_shape < alike) return {Verdict::unlike};
  const double shown = varies && most_shape > certain ? best_lag : 0.0;
  if (most > certain) return {Verdict::same, ratio, shown};
  return {};
}

// Uses two poses half a second apart only if there are other poses near them.
std::vector<Piece> pieces_of_poses(const std::vector<PoseSample>& seen, double camera_yaw,
                                   double begin, double end) {
  std::vector<Piece> result;
  for (std::size_t i = 0, j = 0; i < seen.size(); ++i) {
    const double t = seen[i].t;
    if (t < begin || t > end || (!result.empty() && t < result.back().t + stride - 1e-3)) continue;
    j = std::max(i, j);
    while (j + 1 < seen.size() && seen[j + 1].t - t <= piece + 1e-3) ++j;
    const double span = seen[j].t - t;
    if (span < 0.7 * piece || seen[j].t > end) continue;
    const double turn = std::remainder(seen[j].yaw - seen[i].yaw, 2.0 * std::numbers::pi);
    const double heading = seen[i].yaw + 0.5 * turn - camera_yaw;
    const double along =
        (seen[j].x - seen[i].x) * std::cos(heading) + (seen[j].y - seen[i].y) * std::sin(heading);
    result.push_back({t, turn * piece / span, along * piece / span});
  }
  return result;
}

std::vector<Piece> pieces_of(const Resampled& turned) {
  std::vector<Piece> result;
  const double last = turned.end() - turned.begin - piece;
  for (int k = 0; stride * k <= last; ++k) {
    const double t = turned.begin + stride * k;
    result.push_back({t, turned.at(t + piece) - turned.at(t), 0.0});
  }
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
    const Resampled way = rolled ? integral(*rolled) : Resampled{};
    Trajectory result;
    constexpr std::size_t apart = 5;
    for (std::size_t k = 0; k < turned.value.size(); k += apart) {
      const double t = turned.begin + turned.step * static_cast<double>(k);
      TrajectoryPoint& point = result.points.emplace_back();
      point.t_ns = log_.first_ns + std::llround(1e9 * t);
      point.pose = {rolled ? way.at(t) : 0.0, 0.0, turned.value[k]};
    }
    return result;
  }

 private:
  const daemon::Config& config_;
  const SignalLog& log_;
  double begin_ = 0.0, end_ = 0.0;
};

bool is_far_off(double ratio) {
  return !kind("scale_off").limits.hold(ratio);
}

// Distance of a wheel / that of the poses, median of the pieces; empty if too little was driven.
std::optional<double> ratio_of_ways(const std::vector<Piece>& pieces, const Resampled& speed,
                                    double least) {
  const Resampled way = integral(speed);
  std::vector<double> ratios;
  for (const Piece& p : pieces)
    if (std::fabs(p.along) >= least && p.t >= way.begin && p.t + piece <= way.end())
      ratios.push_back((way.at(p.t + piece) - way.at(p.t)) / p.along);
  if (std::ssize(ratios) < fewest) return std::nullopt;
  return median_of(std::move(ratios));
}

}  // namespace

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
      steered ? compare(pieces_of(turned), *steered, least_turn) : Comparison{};
  const auto wrong_sign = [](Source sensor, const std::string& others) {
    return found(kind("wrong_sign"), name_of(sensor), "turns the other way than " + others,
                 key_of(sensor));
  };
  if (poses.empty()) {
    if (gyro_to_steering.verdict == Verdict::other_way)
      return found(kind("wrong_sign"), name_of(Source::yaw_rate),
                   "turns the other way than wheels and steering",
                   key_of(Source::yaw_rate) + ".scale and " + key_of(Source::steering));
    if (!steered) return std::nullopt;
    // Compares in both directions: compare() limits large pieces, which hides small ratios.
    const double far = compare(pieces_of(*steered), turned, least_turn).ratio;
    const double little = gyro_to_steering.ratio;
    if (std::max(far, little) > far_off_unseen)
      return found(kind("scale_off"), name_of(Source::yaw_rate),
                   "turns " + fixed(std::max(far, little), 1) + " times as " +
                       (far > little ? "far" : "little") + " as by wheels and steering",
                   "yaw_rate, steering and the wheels");
    return std::nullopt;
  }

  if (const auto units =
          check_units(poses_of + "'s poses", poses, {.trajectory = signals.driven()});
      !units.empty())
    return units.front();

  const std::vector<Piece> seen = pieces_of_poses(
      in_order(poses, log.first_ns), config.camera.lever_arm[2], signals.begin(), signals.end());
  std::vector<double> yaw_sigmas, sigmas;
  for (const estimator::CameraPose& pose : poses) {
    yaw_sigmas.push_back(pose.sigma_yaw);
    sigmas.push_back(std::max(pose.sigma_x, pose.sigma_y));
  }
  const double least = std::max(least_turn, 4.0 * median_of(std::move(yaw_sigmas)));
  const Comparison gyro = compare(seen, turned, least);
  if (gyro.verdict == Verdict::other_way) {
    if (gyro_to_steering.verdict == Verdict::same)
      return found(kind("camera_mirrored"), source,
                   "turns the other way than yaw_rate and steering: is its file of this drive?");
    return wrong_sign(Source::yaw_rate, poses_of);
  }
  if (gyro.verdict == Verdict::unlike) {
    if (options.unrelated == UnrelatedPoses::accept) return std::nullopt;
    return found(kind("camera_turns_unrelated"), source,
                 "its turns and those of yaw_rate have nothing in common");
  }
  if (options.unrelated == UnrelatedPoses::refuse && std::fabs(gyro.lag) > off_clock)
    return found(kind("clocks_differ"), source,
                 "the times of its poses are " + fixed(std::fabs(gyro.lag), 1) +
                     (std::fabs(gyro.lag) < (latest - 0.5) * lag_step ? " s " : " s or more ") +
                     (gyro.lag < 0.0 ? "late" : "early") + " compared with yaw_rate");
  if (gyro.verdict == Verdict::same && is_far_off(gyro.ratio))
    return found(kind("scale_off"), name_of(Source::yaw_rate),
                 "turns " + fixed(gyro.ratio, 2) + " times as far as " + poses_of,
                 key_of(Source::yaw_rate));

  for (const Source wheel : wheel_sources) {
    if (!log.has(wheel)) continue;
    const auto ratio =
        ratio_of_ways(seen, signals.speed(wheel), std::max(least_way, 6.0 * median_of(sigmas)));
    if (ratio && *ratio < 0.0)
      return found(kind("runs_backwards"), name_of(wheel),
                   "runs backwards where " + poses_of + " sees the car go ahead", key_of(wheel));
    if (ratio && is_far_off(*ratio))
      return found(kind("scale_off"), name_of(wheel),
                   "is " + fixed(*ratio, 2) + " times as fast as " + poses_of + " sees the car",
                   key_of(wheel));
  }

  if (!steered) return std::nullopt;
  const Comparison steering = compare(seen, *steered, least);
  const bool by_gyro =
      gyro.verdict == Verdict::same && gyro_to_steering.verdict == Verdict::other_way;
  if (steering.verdict == Verdict::other_way || by_gyro)
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
