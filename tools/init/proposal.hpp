// What odom init works with: candidates, which are signals of a database that may have a role, from
// the words of their names, their unit and their length (roles.cpp), with the signals next to them
// that contain their validity or sign (companions.cpp); the traffic of a drive and its signals as
// series (traffic.cpp); the proposal, which is the signal that probably measures each role, with
// reasons and warnings; and those numbers of a car that no database and no log contains.
#pragma once

#include <array>
#include <cstdint>
#include <map>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include <Eigen/Core>

#include "can_protocol/dbc/dbc.hpp"
#include "can_protocol/decode/signal_binding.hpp"
#include "can_protocol/decode/units.hpp"
#include "can_protocol/frame.hpp"
#include "estimator/common/measurement.hpp"
#include "tools/identify/common/agreement.hpp"
#include "tools/identify/common/car_model.hpp"
#include "tools/identify/common/signal_log.hpp"

namespace odomd::tools {

/// A signal next to a measured one, in its message.
struct Companion {
  const can::Signal* signal = nullptr;
  /// The physical value that means "valid", or "negative"; none if only a log can show it.
  std::optional<double> value;
};

/// A signal that may have a role. Points into the databases.
struct Candidate {
  estimator::Source role{};
  const can::Message* message = nullptr;
  const can::Signal* signal = nullptr;
  const can::Signal* fraction = nullptr;  ///< the fine part of a coarse signal, which is added
  std::vector<Companion> valid_when;      ///< all must hold; those without a value are ignored
  std::optional<Companion> sign;
  std::optional<can::UnlessRaw> unless_raw;  ///< named by the database, or all ones in the log
  can::Unit unit = can::Unit::none;          ///< the database's, or the role's usual one
  double score = 0.0;                        ///< comparable within a role only
  std::vector<std::string> warnings;         ///< why it is uncertain: name, unit, multiplexed
  std::optional<double> forward, reverse;    ///< physical values; of the role direction only

  [[nodiscard]] std::string name() const { return message->name + "." + signal->name; }
};

/// At most eight candidates for a role, the best first.
[[nodiscard]] std::vector<Candidate> candidates_for(estimator::Source role,
                                                    std::span<const can::Database> databases);

// The signals next to a measured one (companions.cpp).

/// Found by name ("YawRate_Stat", "QBit_YawRate", "IMU_Valid") and by the names of the values.
[[nodiscard]] std::vector<Companion> validity_of(const can::Message& message,
                                                 const can::Signal& measured);

/// Found by name ("VZ_YawRate", "YawRateSign", "YawRate_Dir"), for a signal without a sign.
[[nodiscard]] std::optional<Companion> sign_of(const can::Message& message,
                                               const can::Signal& measured);

/// Raw values that the database names as invalid.
[[nodiscard]] std::vector<std::int64_t> invalid_raws(const can::Signal& measured);

/// Sets the value of a validity signal to the most frequent one in the second half of the log.
/// Without a log, the database's value is kept, if any. If the log contradicts the database, the
/// value is removed with a warning.
void settle(Companion& companion, std::span<const double> seen, std::vector<std::string>& warnings);

/// The frames of a drive, and the names of their buses.
struct Traffic {
  std::string name;  ///< "drive.log", "can0"
  std::vector<can::Frame> frames;
  std::vector<std::string> buses;
  std::vector<std::string> warnings;  ///< about the logs

  [[nodiscard]] bool empty() const { return frames.empty(); }
};

/// All frames of logs, merged by stamp. Throws like can::MergedLog: file, line, fix.
[[nodiscard]] Traffic read_logs(std::span<const std::string> logs, can::Damage damage);

/// Listens to an interface for this time [s], or until INT. Throws std::invalid_argument if no
/// frame arrived.
[[nodiscard]] Traffic listen(const std::string& interface, double seconds);

/// How often a message is sent, and on which buses.
struct Rhythm {
  double cycle = 0.0;              ///< median time between frames [s]
  double longest = 0.0;            ///< 99.9 % of these times are shorter [s]
  std::vector<std::string> buses;  ///< the buses that carry it, the busiest first
};

/// The rhythms of those messages of the databases that arrived, by can::frame_key.
[[nodiscard]] std::map<std::uint32_t, Rhythm> rhythms(const Traffic& traffic,
                                                      std::span<const can::Database> databases);

/// The valid SI values of a candidate, decoded as in the daemon with its fraction and sign signals.
/// Sets the candidate's `valid_when` and `unless_raw` from the traffic.
[[nodiscard]] Series series_of(const Traffic& traffic, std::span<const can::Database> databases,
                               Candidate& candidate);

struct Choice {
  Candidate candidate;
  Series series;  ///< SI, as decoded; empty without a log
  double scale = 1.0, offset = 0.0;
  bool scale_fits = false;  ///< the drive confirms the scale of a steering command
  std::optional<double> sigma, timeout, radius, ratio, pole_pairs;  ///< none: odomd's default
  std::vector<std::string> buses;     ///< those that carry the message in the log
  std::string bus;                    ///< the one to take it from; empty: any
  std::vector<std::string> reasons;   ///< why it was chosen, and the origin of its numbers
  std::vector<std::string> warnings;  ///< empty: certain

  [[nodiscard]] bool sure() const { return warnings.empty(); }
  /// Whether the speed comes as an angular velocity.
  [[nodiscard]] bool turns() const {
    return estimator::is_wheel(candidate.role) && can::is_rotation(candidate.unit);
  }
};

struct Proposal {
  std::array<std::optional<Choice>, estimator::source_count> roles;
  std::optional<double> measured_track;  ///< from wheels and gyro [m]
  double lateral = 0.0;                  ///< largest lateral acceleration in the log [m/s²]
  std::vector<std::string> notes;        ///< about the whole proposal

  [[nodiscard]] std::optional<Choice>& of(estimator::Source role) {
    return roles.at(estimator::index_of(role));
  }
  [[nodiscard]] const std::optional<Choice>& of(estimator::Source role) const {
    return roles.at(estimator::index_of(role));
  }
  [[nodiscard]] bool has(estimator::Source role) const { return of(role).has_value(); }
  [[nodiscard]] bool has_axle() const;  ///< has both wheels of an axle
};

/// Makes a proposal from names, units and the traffic on the bus, or from the database alone if
/// there is no traffic. Throws std::invalid_argument if there is no speed.
[[nodiscard]] Proposal propose(std::span<const can::Database> databases, const Traffic& traffic);

/// Numbers of the car that only a person can give, in SI units; none if not given. The message
/// about missing ones says how to measure each (car.cpp).
struct Car {
  std::optional<double> mass, wheelbase, front_axle, track, wheel_radius, steering_ratio, full_lock,
      gear_ratio, pole_pairs;
};

/// The same numbers as texts with their units; empty if not given.
struct CarTexts {
  std::string mass, wheelbase, front_axle, track, wheel_radius, steering_ratio, full_lock,
      gear_ratio, pole_pairs;
};

/// Throws std::invalid_argument naming the option.
[[nodiscard]] Car parse_car(const CarTexts& texts);

/// The options that the proposal needs and that were not given. It always needs mass and wheelbase;
/// the wheel radius for speeds in turns per minute; gear ratio and pole pairs of a motor; the
/// track, if both wheels of an axle are mapped and no gyro measured it; and the full lock, if
/// steering is a command and the drive did not show its scale.
[[nodiscard]] std::vector<std::string> missing_numbers(const Car& car, const Proposal& proposal);

/// Throws std::invalid_argument that lists the missing options with their hints, if there are any.
void require_numbers(const Car& car, const Proposal& proposal);

/// Typical values of a class of cars, for what was not measured.
struct Typical {
  double inertia;                          ///< J_z / (m l_v l_h)
  double stiffness_front, stiffness_rear;  ///< C / weight on the axle [1/rad]
  double grip;                             ///< [m/s²]

  /// Additional front-wheel angle per lateral acceleration, due to slip [rad s²/m].
  [[nodiscard]] double understeer() const {
    return (1.0 / stiffness_front - 1.0 / stiffness_rear) / car_model::gravity;
  }
};

[[nodiscard]] inline Typical typical_for(double wheelbase) {
  constexpr double model_car = 1.0;  // m; shorter wheelbases are models
  return wheelbase < model_car ? Typical{0.5, 4.0, 6.0, 10.0} : Typical{1.0, 15.0, 22.0, 9.0};
}

/// Compares the signals of the log with each other. Sets signs, the scale of the steering, biases
/// and sigmas, and adds reasons and warnings (behaviour.cpp).
void check_behaviour(Proposal& proposal, const Car& car);

// A VESC motor controller (vesc.cpp). The layout of its CAN status frames is published, but their
// identifiers contain a number that the owner sets, so the database is generated.

/// The database with the status frames of this VESC.
[[nodiscard]] std::string vesc_database(int id);

/// Throws std::invalid_argument if the frame with the speed of this VESC is not in the traffic; the
/// message names the VESCs that send one.
void require_frames(int vesc, const Traffic& traffic);

/// Adds warnings about the VESC to the proposal. A gear ratio that is not given is 1.
void settle_motor(Proposal& proposal, int vesc, Car& car);

// The proposed signals while the car moves and their noise (drive_course.cpp), and the scale of the
// steering (steering_scale.cpp).

/// Several signals on one grid over the time that all of them cover, as means over half a second,
/// so that latencies below that hardly matter. Empty if all cover less than half a second
/// in common.
[[nodiscard]] std::vector<Resampled> on_one_grid(const std::vector<const Series*>& signals);

/// All signals at the same times, without those at which the car is at rest or creeps.
struct DriveCourse {
  explicit DriveCourse(const Proposal& proposal);

  [[nodiscard]] const Eigen::ArrayXd& of(estimator::Source role) const {
    return signals.at(estimator::index_of(role));
  }
  [[nodiscard]] bool has(estimator::Source role) const { return of(role).size() > 0; }
  /// Whether the car drives for three seconds.
  [[nodiscard]] bool has_motion() const { return speed.size() >= 60; }

  std::array<Eigen::ArrayXd, estimator::source_count> signals;  ///< empty: no such signal
  Eigen::ArrayXd speed, acceleration;  ///< the wheels' mean [m/s], and its rate of change [m/s²]
};

/// Sets the unit of a steering signal to none if its database gives no unit and it stays within ±1:
/// it is a command, or in radians.
void detect_command(Proposal& proposal);

/// Determines whether the steering angle is that of the front wheels or of the steering wheel and,
/// if the wheelbase is known, their ratio. Sets the scale of the role, with a reason or a warning.
void set_steering_scale(Proposal& proposal, const DriveCourse& drive, const Car& car);

/// Sets the sigmas that the log shows, and the offset of a gyro that was at rest.
void set_noise(Proposal& proposal);

}  // namespace odomd::tools
