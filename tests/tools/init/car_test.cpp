// What is asked about the car.
#include "tools/init/car.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <sstream>

#include "tests/tools/scratch.hpp"

namespace odomd::tools::car_test {
namespace {

using estimator::Source;
using testing::HasSubstr;
using testing::IsEmpty;

TEST(Car, IsAskedForUntilTheAnswerIsANumber) {
  Car car;
  std::istringstream in("heavy\n\n2985g\n0.26\n\n");
  std::ostringstream out;
  ask(missing_first(car, {}), car, in, out);
  EXPECT_DOUBLE_EQ(car.mass.value(), 2.985);
  EXPECT_DOUBLE_EQ(car.wheelbase.value(), 0.26);
  EXPECT_FALSE(car.front_axle.has_value());  // left open
  EXPECT_THAT(out.str(), HasSubstr("not a number"));
  EXPECT_THAT(out.str(), HasSubstr("a number is needed"));  // of the empty answer
}

TEST(Car, RefusesAnAxleBeyondTheWheelbase) {
  Car car = parse_car({.mass = "3", .wheelbase = "0.26"});
  std::istringstream in("0.3\n0.1\n");
  std::ostringstream out;
  ask(missing_first(car, {}), car, in, out);
  EXPECT_DOUBLE_EQ(car.front_axle.value(), 0.1);
  EXPECT_THAT(
      message_of([] { static_cast<void>(parse_car({.wheelbase = "2", .front_axle = "3"})); }),
      HasSubstr("--front-axle"));
}

TEST(Car, SizesUnlikeACarAreAskedForOnceMore) {
  Car car;
  std::istringstream in("2.985\n2.6\n1.3\n2.985\n260mm\n0.13\n");
  std::ostringstream out;
  ask(missing_first(car, {}), car, in, out);
  EXPECT_DOUBLE_EQ(car.wheelbase.value(), 0.26);
  EXPECT_DOUBLE_EQ(car.front_axle.value(), 0.13);
  EXPECT_THAT(out.str(), HasSubstr("2.985 kg on a wheelbase of 2.6 m"));

  Car unusual = parse_car({.mass = "2985", .wheelbase = "0.26", .front_axle = "0.13"});
  unusual.mass.reset();
  std::istringstream twice("2985\n2985\n0.26\n\n");
  ask(missing_first(unusual, {}), unusual, twice, out);
  EXPECT_DOUBLE_EQ(unusual.mass.value(), 2985.0);  // who says it twice means it
}

TEST(Car, EndOfInputNamesTheOption) {
  Car car;
  std::istringstream in;
  std::ostringstream out;
  EXPECT_THAT(message_of([&] { ask(missing_first(car, {}), car, in, out); }), HasSubstr("--mass"));
}

TEST(Car, NothingIsAskedThatIsKnown) {
  const Car car =
      parse_car({.mass = "3", .wheelbase = "260mm", .front_axle = "0.13", .track = "160 mm"});
  EXPECT_THAT(missing_first(car, {}), IsEmpty());
  EXPECT_THAT(missing_last(car, {}), IsEmpty());
}

TEST(Car, OnlyWhatARoleNeedsIsAsked) {
  const auto asked = [](const Proposal& proposal) {
    std::string options;
    for (const auto& questions : {missing_first({}, proposal), missing_last({}, proposal)})
      for (const Question& one : required(questions)) options += std::string(one.option) + ' ';
    return options;
  };
  const auto mapped = [](Source role, can::Unit unit) {
    Proposal proposal;
    Choice& choice = proposal.of(role).emplace();
    choice.candidate.role = role;
    choice.candidate.unit = unit;
    choice.warnings.emplace_back("not compared");
    return proposal;
  };
  const std::string sizes = "--mass --wheelbase ";
  Proposal wheels = mapped(Source::wheel_rear_left, can::Unit::rad_per_s);
  EXPECT_EQ(asked(wheels), sizes + "--wheel-radius ");
  wheels.of(Source::wheel_rear_right) = wheels.of(Source::wheel_rear_left);
  EXPECT_EQ(asked(wheels), sizes + "--wheel-radius --track ");
  wheels.measured_track = 1.5;
  EXPECT_EQ(asked(wheels), sizes + "--wheel-radius ");
  EXPECT_EQ(asked(mapped(Source::motor, can::Unit::m_per_s)), sizes);
  EXPECT_EQ(asked(mapped(Source::motor, can::Unit::rpm)), sizes + "--wheel-radius --gear-ratio ");
  EXPECT_EQ(asked(mapped(Source::motor, can::Unit::erpm)),
            sizes + "--wheel-radius --gear-ratio --pole-pairs ");
  EXPECT_EQ(asked(mapped(Source::steering, can::Unit::deg)), sizes);  // the ratio may stay open
  Proposal command = mapped(Source::steering, can::Unit::none);
  EXPECT_EQ(asked(command), sizes + "--full-lock ");
  command.of(Source::steering)->scale_fits = true;
  EXPECT_EQ(asked(command), sizes);
}

}  // namespace
}  // namespace odomd::tools::car_test
