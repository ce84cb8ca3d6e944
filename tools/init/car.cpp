#include "tools/init/car.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <istream>
#include <ostream>
#include <stdexcept>

#include <fmt/format.h>

#include "daemon/diagnostics/diagnostic.hpp"
#include "tools/identify/common/quantity.hpp"

namespace odomd::tools {
namespace {

struct Item {
  Question question;
  Dimension dimension;
  Plausible range;
  std::optional<double> Car::*value;
  std::string CarTexts::*text;
};

const std::array items{
    Item{{"--mass", "mass ready to drive [kg, or as 2985g]",
          "weighed with battery and all that is on it; odom identify mass helps"},
         Dimension::mass,
         {0.2, 60000.0},
         &Car::mass,
         &CarTexts::mass},
    Item{{"--wheelbase", "wheelbase [m, or as 260mm]",
          "front to rear axle, by a tape along the ground"},
         Dimension::length,
         {0.05, 15.0},
         &Car::wheelbase,
         &CarTexts::wheelbase},
    Item{{"--front-axle", "front axle to centre of gravity [m, or as 175mm]",
          "wheelbase times the rear axle's share of the weight; odom identify cog helps"},
         Dimension::length,
         {0.01, 12.0},
         &Car::front_axle,
         &CarTexts::front_axle},
    Item{{"--track", "track [m, or as 160mm]",
          "middle of a rear tyre to the middle of the other, by a tape"},
         Dimension::length,
         {0.03, 5.0},
         &Car::track,
         &CarTexts::track},
    Item{{"--wheel-radius", "rolling radius of a wheel [m, or as 33mm]",
          "roll the car ten turns of a wheel and divide the way by 62.83"},
         Dimension::length,
         {0.005, 2.0},
         &Car::wheel_radius,
         &CarTexts::wheel_radius},
    Item{{"--steering-ratio",
          "steering ratio: turn of the steering wheel over that of the front wheels",
          "in the data sheet; cars have 12 to 20"},
         Dimension::pure,
         {0.5, 60.0},
         &Car::steering_ratio,
         &CarTexts::steering_ratio},
    Item{{"--full-lock", "angle of the front wheels at a command of 1 [rad, or as 20deg]",
          "turn the steering fully and measure the mean of both front wheels"},
         Dimension::angle,
         {0.05, 1.2},
         &Car::full_lock,
         &CarTexts::full_lock},
    Item{{"--gear-ratio", "turns of the motor for one of a wheel",
          "gear teeth: spur over pinion, times the differential's ratio"},
         Dimension::pure,
         {0.1, 100.0},
         &Car::gear_ratio,
         &CarTexts::gear_ratio},
    Item{{"--pole-pairs", "pole pairs of the motor, as it reports electrical turns",
          "half the poles in its data sheet; 1 if the controller divides by them"},
         Dimension::pure,
         {1.0, 50.0},
         &Car::pole_pairs,
         &CarTexts::pole_pairs},
};

const Item& item_of(std::string_view option) {
  return *std::ranges::find(items, option, [](const Item& item) { return item.question.option; });
}

void set(Car& car, const Item& item, std::string_view text) {
  if (!text.empty())
    car.*item.value = parse_plausible(text, item.dimension, item.question.option, item.range);
}

bool is_optional(const Question& question) {
  return question.option == "--front-axle" || question.option == "--steering-ratio";
}

std::string_view if_empty(const Question& question) {
  if (question.option == "--front-axle") return "; empty: half the wheelbase, a guess";
  return is_optional(question) ? "; empty: as proposed" : "";
}

void check_axle(const Car& car) {
  if (car.front_axle && car.wheelbase && *car.front_axle >= *car.wheelbase)
    throw std::invalid_argument(
        fmt::format("--front-axle: {:g} m is not between the axles, which are {:g} m apart",
                    *car.front_axle, *car.wheelbase));
}

/// Whether mass and wheelbase fit no car (W102), so that one of them has another unit.
bool is_unlike_a_car(const Car& car) {
  if (!car.mass || !car.wheelbase) return false;
  const double base = *car.wheelbase;
  return !diagnostics::kind("mass_unlike_a_car").limits.hold(*car.mass / (base * base * base));
}

void ask_each(const std::vector<Question>& questions, Car& car, std::istream& in,
              std::ostream& out) {
  for (const Question& question : questions) {
    const Item& item = item_of(question.option);
    while (!(car.*item.value)) {
      out << fmt::format("{} ({}{}): ", question.what, question.hint, if_empty(question))
          << std::flush;
      std::string answer;
      if (!std::getline(in, answer)) {
        out << '\n' << std::flush;
        refuse({question});
      }
      if (answer.empty() && is_optional(question)) break;
      if (answer.empty()) out << "a number is needed here; Ctrl-C leaves, and nothing is written\n";
      try {
        set(car, item, answer);
        check_axle(car);
      } catch (const std::invalid_argument& error) {
        (car.*item.value).reset();
        out << error.what() << '\n';
      }
    }
  }
}

}  // namespace

Car parse_car(const CarTexts& texts) {
  Car car;
  for (const Item& item : items) set(car, item, texts.*item.text);
  check_axle(car);
  if (car.pole_pairs && *car.pole_pairs != std::floor(*car.pole_pairs))
    throw std::invalid_argument(
        fmt::format("--pole-pairs: {:g} is not a whole number; it is half the poles of the motor",
                    *car.pole_pairs));
  return car;
}

std::vector<Question> missing_first(const Car& car, const Proposal& proposal) {
  std::vector<Question> missing;
  if (!car.mass) missing.push_back(item_of("--mass").question);
  if (!car.wheelbase) missing.push_back(item_of("--wheelbase").question);
  if (!car.front_axle) missing.push_back(item_of("--front-axle").question);
  if (!car.wheel_radius && proposal.needs_radius())
    missing.push_back(item_of("--wheel-radius").question);
  const auto& motor = proposal.of(estimator::Source::motor);
  if (!motor || !motor->turns()) return missing;
  if (!car.gear_ratio) missing.push_back(item_of("--gear-ratio").question);
  if (motor->candidate.unit == can::Unit::erpm && !car.pole_pairs)
    missing.push_back(item_of("--pole-pairs").question);
  return missing;
}

std::vector<Question> missing_last(const Car& car, const Proposal& proposal) {
  std::vector<Question> missing;
  if (!car.track && !proposal.measured_track && proposal.has_axle())
    missing.push_back(item_of("--track").question);
  const auto& steering = proposal.of(estimator::Source::steering);
  if (!steering || steering->sure()) return missing;
  if (steering->candidate.unit == can::Unit::none) {
    if (!car.full_lock && !steering->scale_fits) missing.push_back(item_of("--full-lock").question);
  } else if (!car.steering_ratio) {
    missing.push_back(item_of("--steering-ratio").question);
  }
  return missing;
}

void ask(const std::vector<Question>& questions, Car& car, std::istream& in, std::ostream& out) {
  ask_each(questions, car, in, out);
  const auto is_size = [](const Question& one) {
    return one.option == "--mass" || one.option == "--wheelbase";
  };
  if (std::ranges::none_of(questions, is_size) || !is_unlike_a_car(car)) return;
  out << fmt::format(
      "{:g} kg on a wheelbase of {:g} m is unlike a car; once more, with the units:\n", *car.mass,
      *car.wheelbase);
  const std::vector<Question> sizes{item_of("--mass").question, item_of("--wheelbase").question,
                                    item_of("--front-axle").question};
  for (const Question& question : sizes) (car.*item_of(question.option).value).reset();
  ask_each(sizes, car, in, out);
}

std::vector<Question> required(std::vector<Question> questions) {
  std::erase_if(questions, is_optional);
  return questions;
}

void refuse(const std::vector<Question>& missing) {
  std::string text = "still needed, and not on the bus:";
  for (const Question& question : missing)
    text += fmt::format("{} {} ({}; {})", &question == missing.data() ? "" : ";", question.option,
                        question.what, question.hint);
  throw std::invalid_argument(text);
}

}  // namespace odomd::tools
