// Which signal gets which role, by name, unit and size.
#include "tools/init/roles.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <string>

namespace odomd::tools::roles_test {
namespace {

using estimator::Source;
using testing::IsEmpty;
using testing::Not;

can::Database database(const std::string& signals, const std::string& message = "MSG") {
  return can::parse_dbc("VERSION \"\"\nBU_: A\nBO_ 100 " + message + ": 8 A\n" + signals + "\n",
                        "test.dbc");
}

std::string signal(const std::string& name, const std::string& unit, int bits = 16) {
  return " SG_ " + name + " : 0|" + std::to_string(bits) + "@1- (0.1,0) [0|0] \"" + unit + "\" A\n";
}

std::string best(Source role, const can::Database& database) {
  const auto found = candidates_for(role, {&database, 1});
  return found.empty() ? "" : found.front().signal->name;
}

TEST(Roles, AreFoundInManySpellings) {
  struct Case {
    Source role;
    const char *name, *unit;
  };
  for (const Case& one : {Case{Source::yaw_rate, "VehYawRate", "deg/s"},
                          {Source::yaw_rate, "YAW_RT", "rad/s"},
                          {Source::yaw_rate, "Giergeschwindigkeit", "°/s"},
                          {Source::accel_x, "LonAccel", "m/s2"},
                          {Source::accel_x, "AccX", "g"},
                          {Source::accel_y, "LAT_ACCEL", "m/s^2"},
                          {Source::accel_y, "Querbeschleunigung", "m/s2"},
                          {Source::wheel_front_left, "WhlSpdFL", "km/h"},
                          {Source::wheel_front_right, "Wheel_Speed_Front_Right", "m/s"},
                          {Source::wheel_rear_left, "Raddrehzahl_HL", "1/min"},
                          {Source::wheel_rear_right, "RRWheelVel", "kph"},
                          {Source::steering, "StrAng", "deg"},
                          {Source::steering, "Lenkradwinkel", "deg"}}) {
    EXPECT_EQ(best(one.role, database(signal(one.name, one.unit))), one.name) << one.name;
  }
}

TEST(Roles, AreNotTakenByOtherQuantities) {
  const can::Database other = database(
      signal("RollRate", "deg/s") + signal("SteeringWheelSpeed", "deg/s") +
      signal("WheelPressureFL", "kPa") + signal("AccelPedal", "%") + signal("YawFlag", "", 1));
  for (const Source role : {Source::yaw_rate, Source::accel_x, Source::accel_y,
                            Source::wheel_front_left, Source::steering, Source::motor})
    EXPECT_EQ(best(role, other), "") << estimator::source_names.at(estimator::index_of(role));
}

TEST(Roles, TakeTheMeasuredValueBeforeARequest) {
  const can::Database both =
      database(signal("YawRateTarget", "deg/s") + signal("YawRate", "deg/s"));
  EXPECT_EQ(best(Source::yaw_rate, both), "YawRate");
  const can::Database request = database(signal("YawRateTarget", "deg/s"));
  const auto found = candidates_for(Source::yaw_rate, {&request, 1});
  ASSERT_EQ(found.size(), 1U);
  EXPECT_THAT(found.front().warnings, Not(IsEmpty()));
}

TEST(Roles, WarnOfAnUnknownUnitAndASpeedThatIsNoWheels) {
  const can::Database unitless = database(signal("YawRate", ""));
  EXPECT_THAT(candidates_for(Source::yaw_rate, {&unitless, 1}).at(0).warnings, Not(IsEmpty()));
  const can::Database car = database(signal("VehicleSpeed", "km/h"));
  EXPECT_THAT(candidates_for(Source::wheel_rear, {&car, 1}).at(0).warnings, Not(IsEmpty()));
  const can::Database clear = database(signal("WheelSpeedRear", "km/h"));
  EXPECT_THAT(candidates_for(Source::wheel_rear, {&clear, 1}).at(0).warnings, IsEmpty());
}

TEST(Roles, FindTheWheelInTheMessagesName) {
  const can::Database wheels = database(
      " SG_ FL : 0|16@1- (0.01,0) [0|0] \"m/s\" A\n SG_ RR : 16|16@1- (0.01,0) [0|0] \"m/s\" A\n",
      "Wheels");
  EXPECT_EQ(best(Source::wheel_front_left, wheels), "FL");
  EXPECT_EQ(best(Source::wheel_rear_right, wheels), "RR");
  EXPECT_EQ(best(Source::wheel_rear_left, wheels), "");
}

TEST(Roles, AddTheFractionOfACoarseAngle) {
  const can::Database steering = database(
      " SG_ STEER_ANGLE : 0|12@1- (1.5,0) [0|0] \"deg\" A\n"
      " SG_ STEER_FRACTION : 16|4@1- (0.1,0) [0|0] \"deg\" A\n");
  const auto found = candidates_for(Source::steering, {&steering, 1});
  ASSERT_EQ(found.size(), 1U);
  ASSERT_NE(found.front().fraction, nullptr);
  EXPECT_EQ(found.front().fraction->name, "STEER_FRACTION");
}

TEST(Roles, ReadTheDirectionFromTheNamesOfAGear) {
  const can::Database gear = database(
      " SG_ GEAR : 0|4@1+ (1,0) [0|15] \"\" A\nVAL_ 100 GEAR 0 \"P\" 1 \"R\" 2 \"N\" 3 \"D\" ;\n");
  const auto found = candidates_for(Source::direction, {&gear, 1});
  ASSERT_EQ(found.size(), 1U);
  EXPECT_EQ(found.front().forward, 3.0);
  EXPECT_EQ(found.front().reverse, 1.0);
}

}  // namespace
}  // namespace odomd::tools::roles_test
