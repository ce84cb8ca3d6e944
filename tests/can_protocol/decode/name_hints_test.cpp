// Hints for a message or signal that is missing in the databases.
#include "can_protocol/decode/name_hints.hpp"

#include "tests/can_protocol/decode/one_binding.hpp"
#include "tests/gtest.hpp"

namespace odomd::can::name_hints_test {
namespace {

constexpr const char* database = R"(BO_ 1 Imu: 8 X
 SG_ AccLongitudinal : 0|16@1- (0.01,0) [0|0] "m/s^2" X
 SG_ AccLateral : 16|16@1- (0.01,0) [0|0] "m/s^2" X
BO_ 2 ESP_02: 8 X
 SG_ YAW_RATE_VALID : 0|1@1+ (1,0) [0|0] "" X
 SG_ YAW_ANGLE : 8|16@1- (0.01,0) [0|0] "deg" X
 SG_ ROLL_RATE : 24|16@1- (0.01,0) [0|0] "deg/s" X
 SG_ YAW_RATE : 40|16@1- (0.01,0) [0|0] "deg/s" X
BO_ 3 ABS_1: 8 X
 SG_ WhlSpdFL : 0|16@1+ (0.01,0) [0|0] "km/h" X
 SG_ WhlSpdFR : 16|16@1+ (0.01,0) [0|0] "km/h" X
 SG_ WhlSpdRL : 32|16@1+ (0.01,0) [0|0] "km/h" X
 SG_ WhlSpdRR : 48|16@1+ (0.01,0) [0|0] "km/h" X
BO_ 4 Steer: 8 X
 SG_ Angle : 0|16@1- (0.1,0) [0|0] "deg" X
 SG_ AngleRate : 16|16@1- (0.1,0) [0|0] "deg/s" X
 SG_ Torque : 32|16@1- (0.1,0) [0|0] "Nm" X
)";

SignalBinding binding(std::string role, std::string message, std::string signal, Unit unit) {
  SignalBinding result = bind(0, std::move(message), std::move(signal), unit);
  result.role = std::move(role);
  return result;
}

const std::vector<Database>& databases() {
  static const std::vector<Database> all{parse_dbc(database, "car.dbc")};
  return all;
}

std::string for_message(const SignalBinding& wanted) {
  return message_hint(databases(), wanted);
}

std::string for_signal(const SignalBinding& wanted) {
  return signal_hint(databases(), *find_message(databases()[0], wanted.message), wanted,
                     wanted.signals[0]);
}

TEST(NameHints, NameTheNearestOrTheSignalOfAnyMessageThatFitsByUnitAndWords) {
  EXPECT_EQ(for_message(binding("yaw_rate", "IMU", "Yaw", Unit::deg_per_s)),
            "; the nearest is 'Imu'");
  EXPECT_EQ(for_signal(binding("wheel_rear_left", "ABS_1", "WhlSpeedRL", Unit::km_per_h)),
            "; the nearest is 'WhlSpdRL'");
  const std::string yaw_rate = "; signal 'YAW_RATE' (deg/s) of message 'ESP_02' would fit";
  EXPECT_EQ(for_message(binding("yaw_rate", "Gyroscope", "Z", Unit::rad_per_s)), yaw_rate);
  EXPECT_EQ(for_signal(binding("yaw_rate", "Imu", "YawRate", Unit::deg_per_s)), yaw_rate);
  EXPECT_THAT(for_message(binding("accel_y", "Gyroscope", "AY_Lateral", Unit::g)),
              HasSubstr("'AccLateral' (m/s^2) of message 'Imu'"));
  // The signal has no word of the role: the message decides.
  EXPECT_EQ(for_message(binding("steering", "Front", "Wheels", Unit::rad)),
            "; signal 'Angle' (deg) of message 'Steer' would fit");
}

TEST(NameHints, KnowAbbreviationsAndInitials) {
  for (const auto& [role, signal] :
       {std::pair{"wheel_front_left", "WhlSpdFL"}, std::pair{"wheel_front_right", "WhlSpdFR"},
        std::pair{"wheel_rear_left", "WhlSpdRL"}, std::pair{"wheel_rear_right", "WhlSpdRR"}})
    EXPECT_THAT(for_message(binding(role, "Wheels", "Speed", Unit::m_per_s)),
                AllOf(HasSubstr("'" + std::string(signal) + "'"), Not(HasSubstr("Imu"))))
        << role;
}

TEST(NameHints, NameNoSignalThatOnlySharesAUnitOrAWord) {
  // The databases have a speed, but no name of a motor; and a yaw angle, but in another unit.
  EXPECT_THAT(for_message(binding("motor", "Inverter", "Speed", Unit::rpm)),
              Not(HasSubstr("ROLL_RATE")));
  EXPECT_THAT(for_message(binding("heading", "Compass", "Yaw", Unit::m_per_s)),
              AllOf(HasSubstr("odom dbc show car.dbc"), Not(HasSubstr("would fit"))));
  EXPECT_THAT(message_hint(databases(), std::string_view{"Gateway"}),
              AllOf(HasSubstr("odom dbc show car.dbc"), Not(HasSubstr("Imu"))));
}

TEST(NameHints, StayInTheMessageForAConditionOfIt) {
  const Message& steer = *find_message(databases()[0], "Steer");
  EXPECT_EQ(nearest_signal_hint(steer, "Anlge"), "; the nearest is 'Angle'");
  EXPECT_EQ(nearest_signal_hint(Message{}, "Angle"), "");
}

}  // namespace
}  // namespace odomd::can::name_hints_test
