// Estimates the latency of each source's stamps from the other sources: every source shows
// something of the car's turning or acceleration, so each is compared with the gyro (or a source
// already aligned with it) and shifted in time until they agree. For the steering, also the dead
// time and time constant between its signal and the front wheels, and from these the delay and lag
// of the actuator, if there is one.
#pragma once

#include <algorithm>
#include <functional>
#include <optional>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "daemon/core/config.hpp"
#include "estimator/common/measurement.hpp"
#include "estimator/common/vehicle.hpp"
#include "tools/cli/output.hpp"
#include "tools/identify/common/finding.hpp"
#include "tools/identify/common/measured.hpp"
#include "tools/identify/common/signal_log.hpp"
#include "tools/identify/common/time_shift.hpp"

namespace odomd::tools {

/// Angle of the front wheels and side slip of the car over a drive, on the gyro's clock.
struct FrontWheels {
  Resampled angle;       ///< δ [rad]
  Resampled side_speed;  ///< v_y of the centre of gravity [m/s]
};

struct SteeringResponse {
  Measured dead_time;  ///< from the steering's stamps to the gyro's [s]; negative: a late sensor
  Measured time_constant;    ///< of the actuator [s]
  Measured in_all;           ///< their sum, more precise than either
  double explained = 0.0;    ///< share of the variance of the yaw rate
  FrontWheels front_wheels;  ///< from the fitted model
  std::string failure;       ///< why the values are not valid; empty if they are
};

/// Drives the single-track model over the whole log with steering and speed, and fits to the gyro:
/// dead time, time constant, the steering's scale and offset, the gyro's bias, and (within their
/// priors) stiffnesses, inertia and relaxation. `speed` and `gyro` share one clock. `report` is
/// called for every simulation.
[[nodiscard]] SteeringResponse steering_response(const estimator::Vehicle& car,
                                                 const Resampled& steering, const Resampled& speed,
                                                 const Series& gyro, std::int64_t origin_ns,
                                                 const ReportProgress& report = {});

/// Adds steering.delay and .lag, determined if the drive shows an actuator and separates the two,
/// and warns if it contradicts the configured values. `clock` is the latency of the gyro's stamps,
/// the reference of the response, in addition to the configured one [s].
void add_actuator(const SteeringResponse& response, const Measured& clock,
                  const estimator::SteeringActuator& configured, Findings& findings);

/// The offset of a source's stamps from the gyro's.
struct SourceOffset {
  estimator::Source source = estimator::Source::yaw_rate;
  std::string against;     ///< name of the source that it was compared with
  double offset = 0.0;     ///< delay of its stamps behind the gyro's [s]
  double sigma = 0.0;      ///< [s]
  double explained = 0.0;  ///< share of its variance that the comparison explains
  std::string failure;     ///< why the offset is not valid; empty if it is
};

struct LatencyEstimate {
  std::vector<SourceOffset> offsets;  ///< of all mapped sources except gyro and steering
  std::optional<SteeringResponse> steering;
};

/// The offsets that can be determined. Throws std::invalid_argument if the log has no gyro or less
/// than ten seconds of driving, and like check_agreement(). `report` receives the progress.
[[nodiscard]] LatencyEstimate estimate_latencies(const daemon::Config& config, const SignalLog& log,
                                                 std::span<const estimator::CameraPose> camera,
                                                 const ReportProgress& report = {});

// Time offsets of single sources: the drive's gyro on an even grid, and signals to compare with it,
// smoothed in the same way.

/// Times are seconds from the log's first frame.
struct GyroDrive {
  const daemon::Config& config;
  const SignalLog& log;
  double begin = 0.0;
  double end = 0.0;
  Resampled yaw_rate;
  Resampled turned;  ///< its integral

  [[nodiscard]] Resampled on_grid(const Series& series) const {
    return resampled(series, log.first_ns, begin, end);
  }
};

/// Two cycles of a signal, within bounds: the interval for its derivative [s].
[[nodiscard]] inline double two_cycles(const Series& series) {
  return std::clamp(2.0 * series.cycle(), 0.01, 0.2);
}

[[nodiscard]] inline Resampled times(const Resampled& a, const Resampled& b) {
  return combined(a, b, std::multiplies{});
}

/// The constant function 1.
[[nodiscard]] inline Resampled constant(const Resampled& like) {
  return on_grid_of(like, [](double) { return 1.0; });
}

/// Averages twice over ± `half`. Use it on both compared signals: then neither is delayed against
/// the other, and the gyro's noise remains small after differentiation.
[[nodiscard]] inline Resampled smooth(const Resampled& signal, double half) {
  return mean_around(mean_around(signal, half), half);
}

[[nodiscard]] inline SourceOffset as_offset(estimator::Source source, std::string against,
                                            const Offset& found) {
  return {source, std::move(against), found.value, found.sigma, found.explained, found.failure};
}

/// The offset of both wheels of an axle, from their speed difference in curves; `front_wheels`
/// improves it for the front axle.
[[nodiscard]] SourceOffset wheel_pair(const GyroDrive& drive, estimator::Source left,
                                      estimator::Source right,
                                      const std::optional<FrontWheels>& front_wheels);

/// The offset of one wheel, axle or motor, from its distance compared with a camera's;
/// `camera_offset` is the delay of the camera's stamps behind the gyro's [s].
[[nodiscard]] SourceOffset speed_by_camera(const GyroDrive& drive, estimator::Source source,
                                           std::span<const estimator::CameraPose> camera,
                                           double camera_offset);

/// The speed of the centre of gravity along x [m/s], from undriven wheels if there are any, on the
/// gyro's clock according to the offset found; empty if no wheel is mapped.
[[nodiscard]] std::optional<Resampled> best_speed(const GyroDrive& drive,
                                                  const std::vector<SourceOffset>& offsets);

}  // namespace odomd::tools
