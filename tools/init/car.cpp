#include "tools/init/proposal.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <stdexcept>
#include <string_view>

#include <fmt/format.h>

#include "tools/cli/text.hpp"
#include "tools/identify/common/inputs.hpp"

namespace odomd::tools {
namespace {

struct Item {
  std::string_view option, hint;  ///< "--mass"; what it is, and how to measure it
  Dimension dimension;
  double from, to;  ///< the range for any car, in SI units
  std::optional<double> Car::*value;
  std::string CarTexts::*text;
};

// Numbers without a hint are never required.
const auto items = std::to_array<Item>({
    {"--mass",
     "mass ready to drive [kg, or as 2985g]; weighed with battery and all its load; odom "
     "identify mass helps",
     Dimension::mass, 0.2, 60000.0, &Car::mass, &CarTexts::mass},
    {"--wheelbase", "wheelbase [m, or as 260mm]; front to rear axle, measured along the ground",
     Dimension::length, 0.05, 15.0, &Car::wheelbase, &CarTexts::wheelbase},
    {"--front-axle", "", Dimension::length, 0.01, 12.0, &Car::front_axle, &CarTexts::front_axle},
    {"--track", "track [m, or as 160mm]; between the middles of the rear tyres", Dimension::length,
     0.03, 5.0, &Car::track, &CarTexts::track},
    {"--wheel-radius",
     "rolling radius of a wheel [m, or as 33mm]; roll the car ten turns of a wheel and divide the "
     "distance by 62.83",
     Dimension::length, 0.005, 2.0, &Car::wheel_radius, &CarTexts::wheel_radius},
    {"--steering-ratio", "", Dimension::pure, 0.5, 60.0, &Car::steering_ratio,
     &CarTexts::steering_ratio},
    {"--full-lock",
     "angle of the front wheels at a command of 1 [rad, or as 20deg]; turn the steering fully and "
     "measure the mean of both front wheels",
     Dimension::angle, 0.05, 1.2, &Car::full_lock, &CarTexts::full_lock},
    {"--gear-ratio",
     "motor turns per wheel turn; gear teeth: spur over pinion, times the differential's ratio",
     Dimension::pure, 0.1, 100.0, &Car::gear_ratio, &CarTexts::gear_ratio},
    {"--pole-pairs",
     "pole pairs of the motor, as it reports electrical turns; half the poles in its data sheet; 1 "
     "if the controller divides by them",
     Dimension::pure, 1.0, 50.0, &Car::pole_pairs, &CarTexts::pole_pairs},
});

}  // namespace

Car parse_car(const CarTexts& texts) {
  Car car;
  for (const Item& item : items)
    if (const std::string& text = texts.*item.text; !text.empty())
      car.*item.value = parse_plausible(text, item.dimension, item.option, {item.from, item.to});
  if (car.front_axle && car.wheelbase && *car.front_axle >= *car.wheelbase)
    refuse("--front-axle: {:g} m is not between the axles, which are {:g} m apart", *car.front_axle,
           *car.wheelbase);
  if (car.pole_pairs && *car.pole_pairs != std::floor(*car.pole_pairs))
    refuse("--pole-pairs: {:g} is not a whole number; it is half the poles of the motor",
           *car.pole_pairs);
  return car;
}

std::vector<std::string> missing_numbers(const Car& car, const Proposal& proposal) {
  const auto& motor = proposal.of(estimator::Source::motor);
  const auto& steering = proposal.of(estimator::Source::steering);
  const auto turns = [](const std::optional<Choice>& speed) { return speed && speed->turns(); };
  const bool motor_turns = turns(motor);
  const bool has_command = steering && steering->candidate.unit == can::Unit::none;
  const auto is_needed = [&](std::string_view option) {
    if (option == "--wheel-radius") return std::ranges::any_of(proposal.roles, turns);
    if (option == "--gear-ratio") return motor_turns;
    if (option == "--pole-pairs") return motor_turns && motor->candidate.unit == can::Unit::erpm;
    if (option == "--track") return !proposal.measured_track && proposal.has_axle();
    if (option == "--full-lock") return has_command && !steering->sure() && !steering->scale_fits;
    return option == "--mass" || option == "--wheelbase";
  };
  std::vector<std::string> missing;
  for (const Item& item : items)
    if (!(car.*item.value) && is_needed(item.option)) missing.emplace_back(item.option);
  return missing;
}

void require_numbers(const Car& car, const Proposal& proposal) {
  std::string text;
  for (const std::string& option : missing_numbers(car, proposal))
    text += fmt::format("{} {} ({})", text.empty() ? "" : ";", option,
                        std::ranges::find(items, option, &Item::option)->hint);
  if (!text.empty()) throw std::invalid_argument("still needed, and not on the bus:" + text);
}

}  // namespace odomd::tools
