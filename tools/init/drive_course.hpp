// The relation of two signals of a drive; the drive as the proposed signals show it, on one grid;
// and parts of check_behaviour() in files of their own.
#pragma once

#include <array>
#include <cstddef>
#include <functional>
#include <vector>

#include "estimator/common/measurement.hpp"
#include "tools/identify/common/resampled.hpp"
#include "tools/identify/common/signal_log.hpp"
#include "tools/init/proposal.hpp"

namespace odomd::tools {

/// y ≈ slope · x + offset, by least squares.
struct Relation {
  double slope = 0.0;
  double offset = 0.0;
  double correlation = 0.0;
  std::size_t count = 0;

  /// Whether the signals correlate, so that the sign is certain.
  [[nodiscard]] bool clear() const;
};

[[nodiscard]] Relation relation_of(const std::vector<double>& y, const std::vector<double>& x);
/// The relation over the time that both signals cover.
[[nodiscard]] Relation relation_of(const Series& y, const Series& x);

/// Several signals on one grid over the time that all cover, as means over half a second, so that
/// smaller latencies hardly matter. Empty if they have less than that in common.
[[nodiscard]] std::vector<Resampled> on_one_grid(const std::vector<const Series*>& signals);

class DriveCourse {
 public:
  explicit DriveCourse(const Proposal& proposal);

  [[nodiscard]] bool has(estimator::Source role) const {
    return !courses_.at(estimator::index_of(role)).value.empty();
  }
  /// Whether the car drives for some seconds.
  [[nodiscard]] bool has_motion() const;

  [[nodiscard]] double at(estimator::Source role, std::size_t i) const {
    return courses_.at(estimator::index_of(role)).value[i];
  }
  /// The mean speed of the wheels [m/s], and its rate of change [m/s²].
  [[nodiscard]] double speed(std::size_t i) const { return speed_.value[i]; }
  [[nodiscard]] double acceleration(std::size_t i) const { return change_.value[i]; }

  /// f at each point where the car drives.
  [[nodiscard]] std::vector<double> moving(const std::function<double(std::size_t)>& f) const;

 private:
  std::array<Resampled, estimator::source_count> courses_;  ///< empty: no such signal
  Resampled speed_, change_;
  double least_speed_ = 0.0;
};

/// Takes a steering signal without a unit that stays within ±1 as a share of the full lock, or in
/// radians: sets its unit to none.
void take_command(Proposal& proposal);

/// Determines whether the steering angle is that of the front wheels or of the steering wheel, and
/// their ratio (if the wheelbase is known): sets the role's scale, with its reason or warning.
void set_steering_scale(Proposal& proposal, const DriveCourse& drive, const Car& car);

/// Sets each sigma for which the log shows another than odomd's default, and the offset of a gyro
/// that was at rest.
void set_noise(Proposal& proposal);

}  // namespace odomd::tools
