// The input of a filter: quantities in SI units and ISO 8855 axes, each with its own time; and
// verdicts on them.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <string_view>

#include "estimator/common/source.hpp"

namespace odomd::estimator {

struct Measurement {
  Source source = Source::yaw_rate;
  std::int64_t time_ns = 0;  ///< time of measurement, not of arrival
  double value = 0.0;
  double sigma = 0.0;  ///< standard deviation, in the value's unit; 0: FilterSettings::sigma
  std::int64_t arrival_ns = 0;  ///< time of arrival in this process; 0: unknown
};

/// A pose of the centre of gravity in the map frame, seen by a camera.
struct CameraPose {
  std::int64_t capture_ns = 0;  ///< time of exposure
  std::int64_t arrival_ns = 0;  ///< time of arrival in this process; 0: unknown
  double x = 0.0;               ///< [m]
  double y = 0.0;               ///< [m]
  double yaw = 0.0;             ///< [rad], counter-clockwise, may exceed ±π
  double sigma_x = 0.0;         ///< [m], map axes
  double sigma_y = 0.0;
  double sigma_yaw = 0.0;  ///< [rad]
};

/// What a filter did with a sample. Every sample gets exactly one verdict.
enum class Verdict : std::uint8_t {
  fused,    ///< used; in a model that holds signals: now the newest value of its source
  gated,    ///< implausible given the state and its covariance, or physically impossible: not used,
            ///< but a slipping wheel's sample is used with little weight
  too_old,  ///< older than the filter's window, the source's max_latency, or the held sample
  future,   ///< more than a period after its arrival (if unknown: after the next tick)
  duplicate,   ///< same source and same time as an earlier sample
  non_finite,  ///< NaN, infinity, a negative sigma, or a camera's sigma that is not positive
  source_off,  ///< the model does not use this source
  failed_protection,
  forced,  ///< used although gated: the filter was wrong, according to the consensus of the sources
  not_valid,  ///< invalid according to valid_when or its raw value; counted by the daemon
  count
};
[[nodiscard]] constexpr bool is_taken(Verdict verdict) noexcept {
  return verdict == Verdict::fused || verdict == Verdict::forced;
}
inline constexpr std::size_t verdict_count = static_cast<std::size_t>(Verdict::count);

inline constexpr std::array<std::string_view, verdict_count> verdict_names{
    "fused",      "gated",      "too_old",           "future", "duplicate",
    "non_finite", "source_off", "failed_protection", "forced", "not_valid"};

/// The integrity layer's finding about a source.
enum class SourceFlag : std::uint8_t {
  ok,
  out_of_range,  ///< impossible for any car (integrity/admission.hpp), twice in succession
  non_finite,    ///< NaN, infinity or an impossible sigma, twice in succession
  frozen,        ///< identical bits in succession although the car has moved on
  drifting,      ///< contradicts the consensus of the other sources
  slipping,      ///< a wheel, an axle or the motor: its speed contradicts the car's
  timed_out,     ///< set by the daemon, like the next flag
  failed_protection,
  count
};
inline constexpr std::array<std::string_view, static_cast<std::size_t>(SourceFlag::count)>
    source_flag_names{"ok",       "out_of_range", "non_finite", "frozen",
                      "drifting", "slipping",     "timed_out",  "failed_protection"};

/// A filter's judgement of a sample in a later step.
struct Judgement {
  Source source = Source::yaw_rate;
  Verdict verdict = Verdict::fused;
  int degrees = 0;  ///< degrees of freedom of the test: 1, for the camera 3; 0: not tested
  std::array<double, 3> innovation{};  ///< ν, in the source's units
  double squared_ratio = 0.0;          ///< νᵀS⁻¹ν
  double test_ratio = 0.0;             ///< νᵀS⁻¹ν / gate
  std::int64_t time_ns = 0;            ///< when the sample was taken
  std::array<double, 3> variance{};    ///< diagonal of S, in the source's units squared
  std::uint32_t count = 1;             ///< number of samples; over 1: a full window dropped them
};

/// Noise of a source from its own samples: standard deviations in the source's unit. 0: not
/// estimated, or not yet. The variance of a wheel at the speed v is stated² + (speed_share v)².
struct SourceNoise {
  double stated = 0.0;       ///< from the settings
  double at_rest = 0.0;      ///< of gyro and accelerometers, limited to a range around `stated`
  double moving = 0.0;       ///< while a wheel turns
  double speed_share = 0.0;  ///< of a wheel

  [[nodiscard]] bool estimated() const noexcept {
    return at_rest > 0.0 || moving > 0.0 || speed_share > 0.0;
  }
};

}  // namespace odomd::estimator
