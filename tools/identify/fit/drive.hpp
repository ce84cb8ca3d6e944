// A drive for the fit: samples and poses in seconds.
#pragma once

#include <optional>
#include <span>
#include <string>
#include <vector>

#include "daemon/core/config.hpp"
#include "estimator/common/measurement.hpp"
#include "tools/identify/common/measured.hpp"
#include "tools/identify/common/signal_log.hpp"

namespace odomd::tools::fitting {

struct FitSample {
  double t = 0.0;  ///< stamp less configured latency [s]
  double value = 0.0;
  estimator::Source source = estimator::Source::yaw_rate;
  double sigma = 0.0;
};

struct FitDrive {
  std::string name;
  double begin = 0.0, end = 0.0;   ///< where poses and speed are known [s]
  std::vector<FitSample> samples;  ///< in the order of time
  std::vector<PoseSample> poses;   ///< in the order of time
  Resampled steering;              ///< as measured
  double steering_sigma = 1e-3;    ///< noise of a steering sample [rad]
  double steering_cycle = 0.01;    ///< time between two steering samples [s]
  Resampled speed, yaw_rate;       ///< approximate, as start values
  std::optional<Measured> rest;    ///< reading of the gyro at standstill [rad/s]
};

/// Time scale relative to a 1:10 car, from Froude's number; an integer from 1 to 3.
[[nodiscard]] double slowness(const daemon::Config& config);

/// Samples closer than this are averaged [s].
[[nodiscard]] double least_spacing(const daemon::Config& config);

/// The part of the log to use, in seconds from its first frame.
struct Part {
  double from = 0.0;
  double to = 1e9;
};

/// Poses come from the camera or a reference. Throws std::invalid_argument, naming the drive, if
/// signals or poses are missing, or overlap for less than ten seconds.
[[nodiscard]] FitDrive prepare(std::string name, const daemon::Config& config, const SignalLog& log,
                               std::span<const estimator::CameraPose> poses, const Part& part = {});

}  // namespace odomd::tools::fitting
