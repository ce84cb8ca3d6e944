// Compares the proposed signals of a drive with each other.
//
// There are four estimates of the yaw rate: (v_R - v_L) / track from the wheels of an axle, the
// gyro's value, v · steering angle / wheelbase and a_y / v. Names of wheels state left and right,
// so they determine the signs of the others. Without a pair of wheels the majority decides, and
// positive is assumed to be left.
#include <algorithm>
#include <array>
#include <cmath>
#include <optional>
#include <ranges>
#include <utility>

#include <fmt/format.h>

#include "tools/init/proposal.hpp"

namespace odomd::tools {
namespace {

using Eigen::ArrayXd;
using estimator::Source;

/// Sensors whose values give something proportional to the yaw rate.
constexpr std::array turn_sensors{Source::yaw_rate, Source::steering, Source::accel_y};

/// Sets radius and ratios of speeds that are sent as angular velocities, and converts their series.
void apply_radius(Proposal& proposal, const Car& car) {
  for (const Source role : wheel_sources) {
    auto& choice = proposal.of(role);
    if (!choice || !choice->turns()) continue;
    choice->radius = car.wheel_radius.value_or(1.0);
    if (role == Source::motor) choice->ratio = car.gear_ratio;
    if (choice->candidate.unit == can::Unit::erpm) choice->pole_pairs = car.pole_pairs;
    const double factor =
        *choice->radius / choice->ratio.value_or(1.0) / choice->pole_pairs.value_or(1.0);
    for (double& value : choice->series.value) value *= factor;
  }
}

/// Compares each wheel with the mean of all.
void compare_speeds(Proposal& proposal, const DriveCourse& drive) {
  constexpr double tolerance = 0.1;
  const auto wheels =
      std::ranges::count_if(wheel_sources, [&](Source role) { return drive.has(role); });
  for (const Source role : wheel_sources) {
    if (!drive.has(role)) continue;
    Choice& choice = *proposal.of(role);
    const ArrayXd& own = drive.of(role);
    if (2 * (own < 0.0).count() > own.size())
      choice.warnings.emplace_back(
          "negative for most of the drive: if the car drove forwards, set scale = -1");
    if (wheels < 2) continue;
    const double ratio = own.sum() / drive.speed.sum();
    if (std::fabs(ratio - 1.0) <= tolerance)
      choice.reasons.emplace_back("agrees with the other wheels");
    else
      choice.warnings.push_back(fmt::format("it reads {:.3g} times the mean of the wheels", ratio));
  }
}

/// Inverts the sign of a signal that contradicts the others.
void invert(Proposal& proposal, DriveCourse& drive, Source role, std::string_view against) {
  Choice& choice = *proposal.of(role);
  choice.scale = -choice.scale;
  for (double& value : choice.series.value) value = -value;
  drive.signals.at(estimator::index_of(role)) *= -1.0;
  choice.reasons.push_back(
      fmt::format("scale negative: its sign is opposite to that of {}", against));
}

std::optional<ArrayXd> wheel_difference(const DriveCourse& drive) {
  for (const auto& [left, right] : std::views::reverse(estimator::wheel_pairs))
    if (drive.has(left) && drive.has(right)) return drive.of(right) - drive.of(left);
  return std::nullopt;
}

/// The values of a turn sensor, made proportional to the yaw rate.
ArrayXd yaw_rate_equivalent(const DriveCourse& drive, Source role) {
  if (role == Source::steering) return drive.of(role) * drive.speed;
  if (role == Source::accel_y) return drive.of(role) / drive.speed;
  return drive.of(role);
}

void set_signs_from_wheels(Proposal& proposal, DriveCourse& drive, const ArrayXd& difference) {
  for (const Source role : turn_sensors) {
    if (!drive.has(role)) continue;
    Choice& choice = *proposal.of(role);
    const Relation relation = relation_of(yaw_rate_equivalent(drive, role), difference);
    if (!relation.clear())
      choice.warnings.emplace_back("the log shows too few turns to compare it with the wheels");
    else if (relation.slope < 0.0)
      invert(proposal, drive, role, "right minus left wheel speed");
    else
      choice.reasons.emplace_back("its sign agrees with right minus left wheel speed");
  }
}

void set_signs_by_majority(Proposal& proposal, DriveCourse& drive) {
  std::vector<std::pair<Source, Relation>> relations;  // each sensor with the first one
  std::ptrdiff_t sum = 0, clear = 0;
  for (const Source role : turn_sensors) {
    if (!drive.has(role)) continue;
    const Source first = relations.empty() ? role : relations[0].first;
    const Relation relation =
        relation_of(yaw_rate_equivalent(drive, role), yaw_rate_equivalent(drive, first));
    relations.emplace_back(role, relation);
    if (!relation.clear()) continue;
    ++clear;
    sum += relation.slope > 0.0 ? 1 : -1;
  }
  const std::ptrdiff_t all = std::ssize(relations);
  if (all == 0) return;
  const bool undecided = sum == 0 || (clear < all && std::abs(sum) < all && all < 3);
  for (const auto& [role, relation] : relations) {
    Choice& choice = *proposal.of(role);
    if (all < 2) {
      choice.warnings.emplace_back("the log does not show whether positive means left");
    } else if (!relation.clear()) {
      choice.warnings.emplace_back("the log shows too few turns to compare it with the others");
    } else if (undecided) {
      choice.warnings.emplace_back(
          "gyro and steering disagree about left and right; in a left turn both must be positive");
    } else if ((relation.slope > 0.0) != (sum > 0)) {
      invert(proposal, drive, role, "the others");
      choice.warnings.emplace_back(
          "its sign was set by majority; in a left turn it must be positive");
    } else {
      choice.reasons.emplace_back("its sign agrees with the others'");
    }
  }
  proposal.notes.emplace_back(
      "no pair of wheels shows left and right: positive is assumed to be left; turn the car to the "
      "left by hand: yaw_rate and steering must be positive");
}

/// Whether the only speed is that of a motor, which depends on numbers that a person gave.
bool has_only_motor_speed(const Proposal& proposal) {
  return proposal.has(Source::motor) && proposal.of(Source::motor)->turns() &&
         std::ranges::none_of(wheel_sources, [&](Source role) {
           return role != Source::motor && proposal.has(role);
         });
}

/// Lateral acceleration against speed times yaw rate, if they correlate.
std::optional<Relation> lateral_relation(const DriveCourse& drive) {
  if (!drive.has(Source::accel_y) || !drive.has(Source::yaw_rate)) return std::nullopt;
  const Relation relation =
      relation_of(drive.of(Source::accel_y), drive.of(Source::yaw_rate) * drive.speed);
  return relation.clear() ? std::optional(relation) : std::nullopt;
}

void check_yaw_rate(Proposal& proposal, const DriveCourse& drive, const Car& car) {
  if (!drive.has(Source::yaw_rate)) return;
  Choice& choice = *proposal.of(Source::yaw_rate);
  const ArrayXd& yaw = drive.of(Source::yaw_rate);
  proposal.lateral = (yaw * drive.speed).abs().maxCoeff();
  constexpr double factor = 3.0;
  std::optional<double> size;  // measured / expected yaw rate
  bool by_track = false;
  if (const auto difference = wheel_difference(drive)) {
    const Relation relation = relation_of(*difference, yaw);
    if (relation.clear()) {
      proposal.measured_track = std::fabs(relation.slope);
      by_track = car.track.has_value();
      if (by_track) size = *car.track / std::fabs(relation.slope);
    }
  }
  if (const auto relation = lateral_relation(drive); !size && relation)
    size = 1.0 / std::fabs(relation->slope);
  if (!size) return;
  constexpr double max_track_error = 0.2;  // relative; --track compared with the yaw rate
  if (by_track && std::fabs(*size - 1.0) > max_track_error && *size > 1.0 / factor &&
      *size < factor)
    choice.warnings.push_back(fmt::format(
        "it is {:.3g} times the yaw rate from wheels and track: check --track, its scale and unit",
        *size));
  else if (*size > 1.0 / factor && *size < factor)
    choice.reasons.push_back(fmt::format("its magnitude agrees within {:.0f} %",
                                         std::max(1.0, 100.0 * std::fabs(*size - 1.0))));
  else if (!by_track && has_only_motor_speed(proposal))
    proposal.of(Source::motor)
        ->warnings.push_back(fmt::format(
            "yaw rate and acceleration need {:.3g} times its speed: check wheel radius, "
            "gear ratio and pole pairs",
            1.0 / *size));
  else
    choice.warnings.push_back(
        fmt::format("it is {:.3g} times what the other sensors show: check the unit", *size));
}

void check_accel_x(Proposal& proposal, DriveCourse& drive) {
  if (!drive.has(Source::accel_x)) return;
  Choice& choice = *proposal.of(Source::accel_x);
  const Relation relation = relation_of(drive.of(Source::accel_x), drive.acceleration);
  if (!relation.clear()) {
    choice.warnings.emplace_back("the log shows too little braking to compare it with the speed");
    return;
  }
  if (relation.slope < 0.0)
    invert(proposal, drive, Source::accel_x, "the change of the speed");
  else
    choice.reasons.emplace_back("agrees with the change of the speed");
  if (const double slope = std::fabs(relation.slope); slope < 0.5 || slope > 2.0)
    choice.warnings.push_back(fmt::format("it is {:.2g} times the change of the speed", slope));
}

void check_accel_y(Proposal& proposal, const DriveCourse& drive) {
  const auto relation = lateral_relation(drive);
  if (!relation) return;
  Choice& choice = *proposal.of(Source::accel_y);
  constexpr double min_offset = 0.3;            // m/s², the default sigma
  constexpr double max_plausible_offset = 1.5;  // m/s², of a sensor that is tilted by 9°
  if (const double slope = std::fabs(relation->slope); slope < 0.5 || slope > 2.0)
    choice.warnings.push_back(fmt::format("it is {:.2g} times speed times yaw rate", slope));
  if (std::fabs(relation->offset) > min_offset) {
    choice.offset = -std::round(100.0 * relation->offset) / 100.0;
    choice.reasons.emplace_back("offset: mean reading when driving straight");
    if (std::fabs(relation->offset) > max_plausible_offset)
      choice.warnings.push_back(
          fmt::format("an offset of {:.2g} m/s² is large: check its mounting", relation->offset));
  }
}

/// Checks that the gear shows forward at some time in the drive.
void check_direction(Proposal& proposal) {
  auto& choice = proposal.of(Source::direction);
  if (!choice || choice->series.empty()) return;
  if (std::ranges::find(choice->series.value, 1.0) == choice->series.value.end())
    choice->warnings.emplace_back("it never shows forward in the log, although the car drives");
  else
    choice->reasons.emplace_back("shows forward in the log; reverse was not compared");
}

void warn_of_standing_log(Proposal& proposal) {
  bool has_log = false;
  for (auto& choice : proposal.roles)
    if (choice && !choice->series.empty()) {
      has_log = true;
      choice->warnings.emplace_back("the log has no motion to compare it with");
    }
  if (has_log)
    proposal.notes.emplace_back(
        "the car drives less than 3 s in the log: signs and scales were not compared");
}

}  // namespace

void check_behaviour(Proposal& proposal, const Car& car) {
  apply_radius(proposal, car);
  detect_command(proposal);
  DriveCourse drive(proposal);
  if (drive.has_motion()) {
    compare_speeds(proposal, drive);
    if (const auto difference = wheel_difference(drive))
      set_signs_from_wheels(proposal, drive, *difference);
    else
      set_signs_by_majority(proposal, drive);
    check_yaw_rate(proposal, drive, car);
    check_accel_x(proposal, drive);
    check_accel_y(proposal, drive);
    check_direction(proposal);
  } else {
    warn_of_standing_log(proposal);
  }
  set_steering_scale(proposal, drive, car);
  set_noise(proposal);
}

}  // namespace odomd::tools
