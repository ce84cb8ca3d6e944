// The numbers of a car that no database and no log contains: given as options, or asked for, with a
// hint on how to measure them.
#pragma once

#include <iosfwd>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "tools/init/proposal.hpp"

namespace odomd::tools {

/// The numbers as given, with their units; empty: not given.
struct CarTexts {
  std::string mass, wheelbase, front_axle, track, wheel_radius, steering_ratio, full_lock,
      gear_ratio, pole_pairs;
};

struct Car : Known {
  std::optional<double> mass, front_axle;  ///< [kg], [m]
};

/// Throws std::invalid_argument naming the option.
[[nodiscard]] Car parse_car(const CarTexts& texts);

struct Question {
  std::string_view option;  ///< "--mass"
  std::string_view what;    ///< "mass ready to drive [kg, or as 2985g]"
  std::string_view hint;    ///< how to measure
};

/// Numbers that are missing before the log can be read: mass and wheelbase, a radius for speeds in
/// turns per minute, and the motor's gear ratio; the front axle, for which half the wheelbase is a
/// guess.
[[nodiscard]] std::vector<Question> missing_first(const Car& car, const Proposal& proposal);
/// Numbers that are missing after the log has been read: the track, if both wheels of an axle are
/// mapped and no gyro has measured it; the steering ratio or full lock, if uncertain.
[[nodiscard]] std::vector<Question> missing_last(const Car& car, const Proposal& proposal);

/// Asks until each answer is a number with a unit; the front axle and the steering ratio may stay
/// open. A mass and wheelbase that fit no car are asked for again. Throws std::invalid_argument at
/// the end of the input.
void ask(const std::vector<Question>& questions, Car& car, std::istream& in, std::ostream& out);

/// The questions whose answer must not be empty.
[[nodiscard]] std::vector<Question> required(std::vector<Question> questions);

/// Throws std::invalid_argument that lists the questions with their hints.
[[noreturn]] void refuse(const std::vector<Question>& missing);

}  // namespace odomd::tools
