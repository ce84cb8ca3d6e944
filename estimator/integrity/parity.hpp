// What each source says of the motion, as equations: the parities that the sources are held to.
//
// docs/model.md, "Parities".
#pragma once

#include <array>
#include <cstdint>

#include "estimator/common/measurement.hpp"
#include "estimator/common/tuning.hpp"
#include "estimator/common/vehicle.hpp"
#include "estimator/integrity/consensus.hpp"
#include "estimator/integrity/witness.hpp"

namespace odomd::estimator::integrity {

/// What is known of the sensors beforehand.
struct Sensors {
  Vehicle car;
  Tuning tuning;
};

/// What has been learnt of sensors that err always the same way, and how well.
struct Known {
  double gyro_bias = 0.0;  ///< [rad/s]
  double gyro_bias_sigma = Tuning{}.gyro_bias;
  double steering_offset = 0.0;  ///< [rad]
  double steering_offset_sigma = Tuning{}.steering_offset;
  double wheel_slip = Tuning{}.wheel_slip;  ///< of a driven wheel, per acceleration [s²/m]
  double camera_unrest = 1.0;               ///< variance of its poses over the stated one
};

/// What has been heard, up to a time.
struct Heard {
  std::int64_t now_ns = 0;
  Sources out = 0;                              ///< are distrusted
  std::array<Witness, source_count> sources{};  ///< the camera's: see below
  Witness seen_speed;                           ///< v_x by the camera's poses [m/s]
  Witness seen_turn;                            ///< ψ̇ by the camera's poses [rad/s]
  double felt_speed = 0.0;  ///< v_x by the accelerometer since it was last known
  double felt_sigma = 100.0;
  double felt_slope = 0.0;  ///< slope and bias: what is felt more [m/s²], of lately ...
  double felt_slope_sigma = 0.06 * gravity;  ///< ... and by how much it changes
  double felt_for_s = 2.0;                   ///< that is the mean of so long [s], at least ...
  std::int64_t rests_since_ns = 0;           ///< no wheel turns, and nothing else is felt
  double speed_sigma = 100.0;
  double untold_s = 0.0;           ///< for so long nothing has told the speed
  std::array<double, 2> speeds{};  ///< v_x as it was agreed on last, by the time that it is over
  std::array<double, 2> turns{};   ///< ψ̇ likewise
  std::int64_t slid_ns = 0;        ///< when the car might last slide; 0: never
  Known known;
  std::array<double, source_count> radius{};  ///< by how much a wheel reads more than the others
  double load = 0.0;          ///< by how much more an outer wheel does at 1 g to the side ...
  double load_sigma = 0.013;  ///< ... and how well that is known

  [[nodiscard]] double speed(Over over = Over::short_time) const noexcept {
    return speeds[static_cast<std::size_t>(over)];
  }
  [[nodiscard]] double turn(Over over = Over::short_time) const noexcept {
    return turns[static_cast<std::size_t>(over)];
  }
  /// The car may have been sliding in the last so many seconds.
  [[nodiscard]] bool slides(std::int64_t time_ns, double lately_s) const noexcept {
    return slid_ns != 0 && seconds_between(slid_ns, time_ns) < lately_s;
  }
  /// It is heard, and believed.
  [[nodiscard]] bool tells(Source source) const noexcept {
    return by(source).alive(now_ns) && (out & only(source)) == 0;
  }
  [[nodiscard]] const Witness& by(Source source) const noexcept {
    return sources[index_of(source)];
  }
};

/// What surely pushes the car sideways: demanded by its motion, and felt [m/s²].
[[nodiscard]] double side_push(const Heard& heard, Over over) noexcept;

/// With more to the side all tyres may slide [m/s²].
inline constexpr double limit = 4.0;

/// A gyro that reads more than that turns [rad/s].
inline constexpr double largest_gyro_bias = 0.5;

/// Whether what a gyro reads while no wheel turns may as well be its bias.
[[nodiscard]] bool is_steady(const Witness& gyro) noexcept;

/// Of all that is alive; where wheels that know no sign turn `backwards`.
[[nodiscard]] Consensus parities(const Sensors& sensors, const Heard& heard, bool backwards,
                                 Over over) noexcept;

}  // namespace odomd::estimator::integrity
