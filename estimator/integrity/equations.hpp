// The equation that each source gives for the motion of the car (parity equations).
//
// docs/model.md, "Equations".
#pragma once

#include <array>
#include <cstdint>

#include "estimator/common/measurement.hpp"
#include "estimator/common/symmetric3.hpp"
#include "estimator/common/tuning.hpp"
#include "estimator/common/vehicle.hpp"
#include "estimator/integrity/consensus.hpp"
#include "estimator/integrity/source_history.hpp"

namespace odomd::estimator::integrity {

/// Constant parameters of the car and its sensors.
struct Sensors {
  Vehicle car;
  Tuning tuning;

  /// The fastest change of ψ̇ that is not an outlier [rad/s²].
  [[nodiscard]] double turn_in() const noexcept {
    return tuning.turn_in * gravity / car.wheelbase();
  }
};

/// Systematic errors of the sensors, as the filter has estimated them.
struct SensorErrors {
  double gyro_bias = 0.0;  ///< [rad/s]
  double gyro_bias_sigma = Tuning{}.gyro_bias;
  double steering_offset = 0.0;  ///< [rad]
  double steering_offset_sigma = Tuning{}.steering_offset;
  double wheel_slip = Tuning{}.wheel_slip;  ///< slip of a driven wheel, per acceleration [s²/m]
  double camera_noise_scale = 1.0;          ///< variance of camera poses / stated variance
  double rear_slip = 0.0;        ///< the rear axle's speed to the side, v_y - l_h ψ̇ [m/s]
  double rear_slip_sigma = 0.0;  ///< [m/s]
  bool speed_known = false;      ///< by a camera or an undriven wheel
  double gyro_latency = Tuning{}.latency;  ///< error of the configured latency, plus one sigma [s]
  std::array<double, source_count> dead_band{};  ///< a wheel that reads 0 may be this fast [m/s]
};

/// Largest sigma of the offset that slopes cause [g]; three times this bounds the offset.
inline constexpr double largest_slope = 0.06;

/// Whether `since_ns` (0: never) is within four averaging times before `time_ns`.
[[nodiscard]] inline bool lately(std::int64_t since_ns, std::int64_t time_ns, Over over) noexcept {
  return since_ns != 0 && seconds_between(since_ns, time_ns) < 4.0 * seconds_of(over);
}

/// All observations up to `now_ns`, and what was learnt from them.
struct Observations {
  std::int64_t now_ns = 0;
  Sources distrusted = 0;
  std::array<SourceHistory, source_count> sources{};  ///< the camera's contains only times
  SourceHistory camera_speed;                         ///< v_x between camera poses [m/s]
  SourceHistory camera_yaw_rate;                      ///< ψ̇ between camera poses [rad/s]
  double camera_scatter = 1.0;                        ///< variance of these / expected variance
  double integrated_speed = 0.0;                      ///< v_x by integrating accel_x [m/s]
  double integrated_sigma = unknown_speed;
  double accel_offset = 0.0;  ///< offset of accel_x, from slope and bias [m/s²]
  double accel_offset_sigma = largest_slope * gravity;  ///< sigma of the offset's variation [m/s²]
  double offset_averaging_s = 2.0;                      ///< averaging time of offset and sigma
  std::int64_t still_since_ns = 0;                      ///< since then no sensor has shown motion
  double speed_unknown_s = 0.0;            ///< time since a source last measured the speed
  std::array<Solution, 2> last_consensus;  ///< indexed by Over
  std::int64_t last_slide_ns = 0;          ///< last time that the car may have slid; 0: never
  std::int64_t slid_ns = 0;                ///< last time that the car slid; 0: never
  double spin = 0.0;  ///< of a driven wheel, from its slide; largest in the long mean's time [m/s]
  SensorErrors errors;
  std::array<double, source_count> radius{};  ///< relative error of each wheel's speed

  [[nodiscard]] double speed(Over over = Over::short_time) const noexcept {
    return last_consensus[static_cast<std::size_t>(over)].motion[of::speed];
  }
  [[nodiscard]] double yaw_rate(Over over = Over::short_time) const noexcept {
    return last_consensus[static_cast<std::size_t>(over)].motion[of::yaw_rate];
  }
  /// Whether the car slid, or may have, within four averaging times before `time_ns`.
  [[nodiscard]] bool slides(std::int64_t time_ns, Over over = Over::short_time) const noexcept {
    return lately(last_slide_ns, time_ns, over);
  }
  [[nodiscard]] bool slid() const noexcept { return lately(slid_ns, now_ns, Over::short_time); }
  /// Whether a camera sees the car.
  [[nodiscard]] bool seen() const noexcept { return camera_speed.alive(now_ns); }
  /// Sigma of a wheel whose speed has just changed faster than a car's can [m/s].
  [[nodiscard]] double slip_sigma(Source wheel) const noexcept {
    return Tuning{}.slip_share * std::abs(history(wheel).new_slip);
  }
  /// Whether a wheel's speed has changed faster than a car's can, and has not changed back.
  [[nodiscard]] bool slips(Source wheel) const noexcept {
    const SourceHistory& recent = history(wheel);
    return std::abs(recent.slip) >
           Tuning{}.sliding_slip * std::abs(speed()) + most_sigmas * recent.sigma;
  }
  /// Whether the source is alive and trusted.
  [[nodiscard]] bool usable(Source source) const noexcept {
    return history(source).alive(now_ns) && (distrusted & only(source)) == 0;
  }
  [[nodiscard]] const SourceHistory& history(Source source) const noexcept {
    return sources[index_of(source)];
  }
  /// Whether a source repeats its bits, except for a steering command at 0 or at full lock.
  [[nodiscard]] bool repeats(Source source) const noexcept {
    const SourceHistory& recent = history(source);
    const bool rests = source == Source::steering &&
                       (recent.value == 0.0 || std::abs(recent.value) >= recent.largest);
    return recent.repeats() && !rests;
  }
};

/// Lateral acceleration on which motion and accelerometer agree: the smaller of the two [m/s²]; 0
/// if their signs differ.
[[nodiscard]] double lateral_accel(const Observations& observed, Over over) noexcept;

/// No car changes its speed faster [m/s²].
inline constexpr double largest_accel = 1.5 * gravity;
/// No car changes its yaw rate faster [rad/s²].
inline constexpr double largest_yaw_accel = 30.0;

/// A slower car may be at rest, and may reverse [m/s].
inline constexpr double slowest_rolling = 0.1;

/// Sources whose equations are models of the turn.
inline constexpr Sources turn_models = only(Source::accel_y) | only(Source::steering);
/// Above this lateral acceleration all tyres may slide [m/s²].
inline constexpr double sliding_accel = 4.0;
/// A larger reading of a gyro is a turn, not a bias [rad/s].
inline constexpr double largest_gyro_bias = 0.5;

/// A wheel slower than this may be stationary [m/s].
inline constexpr double slowest_turning = 2.0 * estimator::slowest_turning;

/// Radii and slopes are not learnt at lower speeds [m/s].
inline constexpr double min_learning_speed = 0.3;

/// Whether the gyro's reading may be its bias: small and constant.
[[nodiscard]] bool is_steady(const SourceHistory& gyro) noexcept;

/// The equations of all sources that are alive. `backwards`: unsigned wheel speeds are negative.
[[nodiscard]] Consensus equations(const Sensors& sensors, const Observations& observed,
                                  bool backwards, Over over) noexcept;

/// Learns the radius error of each wheel from the residuals of `all` at `base` over `dt` [s]. Call
/// it while no source is suspected.
void learn_radii(const Consensus& all, const Solution& base, double dt,
                 Observations& observed) noexcept;

/// Integrates the measured acceleration over `dt` [s], unless accel_x is silent or distrusted.
/// If all wheels are distrusted, it stops once the car stands.
void integrate_acceleration(const Sensors& sensors, Observations& observed, double dt,
                            bool wheels_distrusted) noexcept;

/// Moves the integrated speed towards the consensus, unless the two contradict each other or the
/// consensus is `contradicted`. If `learns`, learns the offset of the accelerometer (slope and
/// bias) from the difference of the two. Call it while wheels or a camera measure the speed.
void follow_consensus(Observations& observed, double dt, bool contradicted, bool learns) noexcept;

/// A misfit above this needs a fault to explain it. Scores are -2 log of a likelihood ratio.
inline constexpr double gate = 25.0;
/// The best hypothesis must be better than every other hypothesis by this.
inline constexpr double margin = 6.0;

/// The sources at fault among the trusted ones with an equation in `all`. `base` is the solution
/// from all trusted sources, `without_wheels` from all but the wheels. Returns none if no
/// hypothesis explains the misfit of `base`, or if two explain it about equally well.
[[nodiscard]] Sources isolate_fault(const Observations& observed, const Consensus& all,
                                    const Solution& base, const Solution& without_wheels) noexcept;

}  // namespace odomd::estimator::integrity
