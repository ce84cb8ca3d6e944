// Assignment of signals to roles, by name, unit and size.
#include "tools/init/proposal.hpp"

#include <optional>

#include "tests/gtest.hpp"

namespace odomd::tools::roles_test {
namespace {

using estimator::Source;

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

TEST(Roles, AreNotTakenBySignalsOfAnotherUnitOrMeaning) {
  struct Case {
    Source role;
    const char *message, *name, *unit, *values;
  };
  for (const Case& one : {
           Case{Source::wheel_rear_left, "ESP_07", "ESP_RTA_HL", "%", ""},
           {Source::wheel_front_left, "WheelData", "WhlRotatFl_No_Cnt", "Unitless", ""},
           {Source::wheel_front_left, "Wheels", "WhlPulseFL", "", ""},
           {Source::wheel_rear, "Wheels", "WheelVelDrvnChksm", "", ""},
           {Source::wheel_rear, "Wheels", "WhlGndVelLeft", "km/h", ""},
           {Source::wheel_rear, "Vision_Obj_Track_12", "LongVlctyTrk12", "m/s", ""},
           {Source::yaw_rate, "MSG", "YawRateTarget", "deg/s", ""},
           {Source::yaw_rate, "TrailerAid", "YawRate", "deg/s", ""},
           {Source::yaw_rate, "MSG", "TrlrYaw_W_Actl", "rad/s", ""},
           {Source::accel_x, "SCS", "VehTrgtLongtAcc", "", ""},
           {Source::steering, "SteeringStatus", "AlwaysF0", "", ""},
           {Source::steering, "LWI", "LWI_Lenkradw_Geschw", "", ""},
           {Source::direction, "GEAR", "GEAR_BUTTON", "", "1 \"D\" 2 \"R\""},
           {Source::direction, "GEAR", "TrnGear_D_RqDrv", "", "1 \"Drive\" 2 \"Reverse\""},
       }) {
    std::string text = signal(one.name, one.unit);
    if (*one.values != '\0')
      text += std::string("VAL_ 100 ") + one.name + ' ' + one.values + " ;\n";
    EXPECT_EQ(best(one.role, database(text, one.message)), "") << one.name;
  }
}

TEST(Roles, PreferThePlainestNameAndTheGearToItsLever) {
  EXPECT_EQ(best(Source::yaw_rate,
                 database(signal("YawRateTarget", "deg/s") + signal("YawRate", "deg/s"))),
            "YawRate");
  EXPECT_EQ(best(Source::steering,
                 database(signal("PaStrAnglVal", "deg") + signal("STEERING_ANGLE", "deg"))),
            "STEERING_ANGLE");
  EXPECT_EQ(best(Source::direction, database(signal("GearLever", "") + signal("GearActual", "") +
                                             "VAL_ 100 GearLever 1 \"D\" 2 \"R\" ;\n"
                                             "VAL_ 100 GearActual 1 \"D\" 2 \"R\" ;\n")),
            "GearActual");
}

TEST(Roles, FindTheValidityAndTheSignOfASignal) {
  struct Case {
    const char *name, *companion, *values;
    std::optional<double> valid, negative;
  };
  for (const Case& one : {
           Case{"ESP_Gierrate", "ESP_QBit_Gierrate", "", 0.0, {}},
           {"ESP_Querbeschleunigung", "ESP_QBit_Querb", "", 0.0, {}},
           {"VehYaw_W_Actl",
            "VehYawWActl_D_Qf",
            "3 \"OK\" 1 \"No_Data_Exists\" 0 \"Faulty\"",
            3.0,
            {}},
           {"YAW_RATE", "YAW_RATE_VALIDITY", "1 \"Valid\" 0 \"Invalid\"", 1.0, {}},
           {"StrgWhlAngHSC2", "StrgWhlAngVHSC2", "1 \"Invalid\" 0 \"Valid\"", 0.0, {}},
           {"WHEEL_SPEED_FL", "WHEEL_SPEED_FL_FAULT", "", 0.0, {}},
           {"IMU_YawRtVal", "IMU_YawSigSta", "0 \"Init\" 1 \"Normal\" 2 \"Faulty\"", 1.0, {}},
           {"PowerIn", "Power_Stat", "1 \"No_Fault\" 0 \"Fault\"", 1.0, {}},
           {"YawRate", "Valid", "", 1.0, {}},  // validity of the whole message
           {"YawRate", "RollRate_Valid", "", {}, {}},
           {"ESP_Gierrate", "ESP_VZ_Gierrate", "", {}, 1.0},
           {"STEERING_ANGLE",
            "STEERING_ANGLE_SIGN",
            "1 \"Left CounterClockwise\" 0 \"Right Clockwise\"",
            {},
            0.0},
           {"WheelSpeedFL",
            "WheelSpeedFL_Dir",
            "0 \"Unknown\" 1 \"Forward\" 2 \"Backward\"",
            {},
            2.0},
           {"STEERING_ANGLE", "STEERING_RATE_SIGN", "", {}, {}},
       }) {
    SCOPED_TRACE(one.companion);
    std::string text = std::string(" SG_ ") + one.name +
                       " : 0|16@1+ (0.1,0) [0|6553] \"\" A\n SG_ " + one.companion + " : 16|" +
                       (*one.values == '\0' ? "1" : "2") + "@1+ (1,0) [0|0] \"\" A\n";
    if (*one.values != '\0')
      text += std::string("VAL_ 100 ") + one.companion + ' ' + one.values + " ;\n";
    const can::Database made = database(text);
    const can::Message& message = made.messages.front();
    auto found = validity_of(message, message.signals.front());
    std::vector<std::string> warnings;
    const std::array in_log{one.valid.value_or(1.0)};
    for (Companion& companion : found) settle(companion, in_log, warnings);
    EXPECT_EQ(found.empty() ? std::nullopt : found.front().value, one.valid);
    const auto sign = sign_of(message, message.signals.front());
    EXPECT_EQ(sign ? sign->value : std::nullopt, one.negative);
  }
}

TEST(Roles, IgnoreRawValuesThatASignalCannotHave) {
  const can::Database made =
      database(signal("YawRate", "deg/s", 9) +
               "VAL_ 100 YawRate 255 \"SNA\" 256 \"Invalid\" -300 \"Fault\" ;\n");
  EXPECT_EQ(candidates_for(Source::yaw_rate, {&made, 1}).at(0).unless_raw.value().values,
            std::vector<std::int64_t>{255});
}

TEST(Roles, WarnOfAnUnknownUnitAndOfASpeedWithoutAWheel) {
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
