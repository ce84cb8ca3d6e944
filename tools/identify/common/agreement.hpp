// Compares the signals of a drive with each other. find_disagreement() checks that they describe
// one car and one drive: it finds wrong signs, scales that are wrong by a large factor, and poses
// of another drive, before anything is estimated from them.
#pragma once

#include <Eigen/Core>
#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "daemon/core/config.hpp"
#include "daemon/diagnostics/diagnostic.hpp"
#include "estimator/common/measurement.hpp"
#include "tools/identify/common/signal_log.hpp"

namespace odomd::tools {

/// y ≈ slope · x + offset, by least squares.
struct Relation {
  double slope = 0.0, offset = 0.0, correlation = 0.0;
  double gain = 0.0;  ///< ratio of their standard deviations
  std::size_t count = 0;

  /// Standard uncertainty of the slope, from the residuals of more than two values.
  [[nodiscard]] double slope_sigma() const {
    const double unexplained = std::max(0.0, 1.0 - correlation * correlation);
    return gain * std::sqrt(unexplained / (static_cast<double>(count) - 2.0));
  }

  /// Whether the signals correlate, so that the sign is certain.
  [[nodiscard]] bool clear() const {
    constexpr std::size_t enough = 40;  // two seconds at 20 Hz
    return count >= enough && std::fabs(correlation) >= 0.6;
  }
};

/// The relation of two signals' values at the same times. It has no slope if there are fewer than
/// two values, or if x is constant.
[[nodiscard]] Relation relation_of(const Eigen::Ref<const Eigen::ArrayXd>& y,
                                   const Eigen::Ref<const Eigen::ArrayXd>& x);

/// A piece of a drive: the motion between two poses, or the same motion as sensors measure it.
struct Piece {
  double from = 0.0, to = 0.0;  ///< since the log's first frame [s]
  double turn = 0.0;            ///< [rad]
  double along = 0.0;           ///< distance along the heading [m]; of poses only

  [[nodiscard]] double length() const { return to - from; }
};

/// Pieces that start at least `stride` [s] apart. Each ends at the first pose at least half a
/// second after its start; pieces longer than `longest` [s] are left out. `lever_arm`: x, y and yaw
/// of the point that the poses observe.
[[nodiscard]] std::vector<Piece> pieces_of(std::span<const PoseSample> poses, double stride,
                                           double longest, const std::array<double, 3>& lever_arm);

/// Pieces of half a second every `stride` seconds, without motion.
[[nodiscard]] std::vector<Piece> even_pieces(double begin, double end, double stride);

/// What to do if the poses' turns are unrelated to the gyro's.
enum class UnrelatedPoses : std::uint8_t {
  refuse,
  accept,  ///< the caller checks the relation and the delay of the poses itself
};

struct AgreementOptions {
  std::string drive;                   ///< prefix of messages; may be empty
  std::string pose_source = "camera";  ///< the name of the poses in messages
  double from = 0.0, to = 1e9;         ///< the part of the log, from its first frame [s]
  UnrelatedPoses unrelated = UnrelatedPoses::refuse;
};

/// Compares pieces of about half a second, with up to 0.4 s between the clocks: the turns of poses,
/// of the gyro, and of wheels with steering (∫ v tan δ / l); and each wheel's distance with the
/// poses' distance along the heading. Too little data counts as agreement. Poses may be in any
/// order; without poses, only gyro and steering are compared.
///
/// Reports the first of: no pose was taken during the log; poses in other units
/// (replay_checks.hpp); yaw_rate or steering turns the other way; the poses' turns differ from
/// the gyro's, or are more than 0.15 s before or after it (unless UnrelatedPoses::accept); yaw_rate
/// or a wheel is off by a factor above 1.5 (without poses: yaw_rate by 3 from wheels and steering);
/// a wheel runs backwards. Later ones may be consequences of earlier ones.
[[nodiscard]] std::optional<diagnostics::Diagnostic> find_disagreement(
    const daemon::Config& config, const SignalLog& log,
    std::span<const estimator::CameraPose> poses, const AgreementOptions& options = {});

/// Throws std::invalid_argument with the text of find_disagreement(), if it finds any.
void check_agreement(const daemon::Config& config, const SignalLog& log,
                     std::span<const estimator::CameraPose> poses,
                     const AgreementOptions& options = {});

}  // namespace odomd::tools
