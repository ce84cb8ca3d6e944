// Whether a drive's sensors tell of one car and one drive at all: signs and sizes that no scale
// near one would mend, and poses of another drive. Looked at before anything is estimated from
// them.
#pragma once

#include <cstdint>
#include <span>
#include <string>

#include "daemon/core/config.hpp"
#include "estimator/common/measurement.hpp"
#include "tools/identify/common/signal_log.hpp"

namespace odomd::tools {

/// What to do where the poses' turn has nothing to do with the gyro's.
enum class Strangers : std::uint8_t {
  refuse,
  pass,  ///< whoever asks finds it out himself, and how late they are
};

struct AgreementOptions {
  std::string drive;            ///< messages begin with it; may be empty
  std::string eye = "camera";   ///< what the poses are of, in messages
  double from = 0.0, to = 1e9;  ///< what of the log is looked at, after its first frame [s]
  Strangers strangers = Strangers::refuse;
};

/// Over pieces of half a second, with up to 0.4 s between the clocks: the turn of the poses, the
/// gyro's, and ∫ v tan δ / l of wheels and steering; the way of each wheel over that of the poses,
/// along the heading. What happens too seldom to tell is passed. Poses in any order; none: only
/// gyro and steering are compared.
///
/// Throws std::invalid_argument that names the key: where yaw_rate or steering turns the other way,
/// where yaw_rate or a wheel is more than 1.5 times off (without poses: yaw_rate 3 times off wheels
/// and steering), or a wheel runs backwards; where the poses turn otherwise than the gyro, or more
/// than 0.15 s before or after it (strangers: pass: neither); where none of them is taken while the
/// log lasts. First of all where the poses are in other units (unit_doubt.hpp).
void check_agreement(const daemon::Config& config, const SignalLog& log,
                     std::span<const estimator::CameraPose> poses,
                     const AgreementOptions& options = {});

}  // namespace odomd::tools
