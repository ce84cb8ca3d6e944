// Bindings that do not fit the databases: the errors name the role, the nearest name and the fix;
// and the hints for a name that the databases lack.
#include "can_protocol/decode/name_hints.hpp"

#include "tests/can_protocol/decode/one_binding.hpp"
#include "tests/gtest.hpp"

namespace odomd::can::binding_errors_test {
namespace {

constexpr const char* esp_car = R"(BO_ 1 Imu: 8 X
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
  static const std::vector<Database> all{parse_dbc(esp_car, "car.dbc")};
  return all;
}

std::string for_message(const SignalBinding& wanted) {
  return message_hint(databases(), wanted);
}

std::string for_signal(const SignalBinding& wanted) {
  return signal_hint(databases(), *find_message(databases()[0], wanted.message), wanted,
                     wanted.signals[0]);
}

TEST(NameHints, SuggestTheNearestNameOrAFittingSignal) {
  EXPECT_EQ(for_message(binding("yaw_rate", "IMU", "Yaw", Unit::deg_per_s)),
            "; the nearest is 'Imu'");
  EXPECT_EQ(for_signal(binding("wheel_rear_left", "ABS_1", "WhlSpeedRL", Unit::km_per_h)),
            "; the nearest is 'WhlSpdRL'");
  const std::string yaw_rate = "; signal 'YAW_RATE' (deg/s) of message 'ESP_02' would fit";
  EXPECT_EQ(for_message(binding("yaw_rate", "Gyroscope", "Z", Unit::rad_per_s)), yaw_rate);
  EXPECT_EQ(for_signal(binding("yaw_rate", "Imu", "YawRate", Unit::deg_per_s)), yaw_rate);
  EXPECT_THAT(for_message(binding("accel_y", "Gyroscope", "AY_Lateral", Unit::g)),
              HasSubstr("'AccLateral' (m/s^2) of message 'Imu'"));
  // The signal's name has no word of the role, so the message's name decides.
  EXPECT_EQ(for_message(binding("steering", "Front", "Wheels", Unit::rad)),
            "; signal 'Angle' (deg) of message 'Steer' would fit");
}

TEST(NameHints, UseAbbreviationsAndInitials) {
  for (const auto& [role, signal] :
       {std::pair{"wheel_front_left", "WhlSpdFL"}, std::pair{"wheel_front_right", "WhlSpdFR"},
        std::pair{"wheel_rear_left", "WhlSpdRL"}, std::pair{"wheel_rear_right", "WhlSpdRR"}})
    EXPECT_THAT(for_message(binding(role, "Wheels", "Speed", Unit::m_per_s)),
                AllOf(HasSubstr("'" + std::string(signal) + "'"), Not(HasSubstr("Imu"))))
        << role;
}

TEST(NameHints, DoNotSuggestASignalThatOnlySharesAUnitOrAWord) {
  // The databases have a speed, but no name of a motor; and a yaw angle, but in another unit.
  EXPECT_THAT(for_message(binding("motor", "Inverter", "Speed", Unit::rpm)),
              Not(HasSubstr("ROLL_RATE")));
  EXPECT_THAT(for_message(binding("heading", "Compass", "Yaw", Unit::m_per_s)),
              AllOf(HasSubstr("odom dbc show car.dbc"), Not(HasSubstr("would fit"))));
  EXPECT_THAT(message_hint(databases(), std::string_view{"Gateway"}),
              AllOf(HasSubstr("odom dbc show car.dbc"), Not(HasSubstr("Imu"))));
}

TEST(NameHints, StayInTheMessageForConditions) {
  const Message& steer = *find_message(databases()[0], "Steer");
  EXPECT_EQ(nearest_signal_hint(steer, "Anlge"), "; the nearest is 'Angle'");
  EXPECT_EQ(nearest_signal_hint(Message{}, "Angle"), "");
}

// Bindings that are refused ---------------------------------------------------------------------

std::string refusal_of(const SignalBinding& refused, const E2eBinding& e2e = imu_protection()) {
  const std::string text = refusal(parse_dbc(car, "car.dbc"), {refused}, {e2e}, {"can0", "can1"});
  return (text.empty() ? "taken" : text) + '\n';
}

TEST(DecoderErrors, NameTheRoleTheNearestNameAndTheFix) {
  struct {
    void (*change)(SignalBinding&);
    std::string error;
  } const cases[]{
      {[](auto& b) { b.message = "IUM"; },
       "signal 'role_1': no message 'IUM' in car.dbc; the nearest is 'IMU'\n"},
      {[](auto& b) { b.signals = {"yaw"}; },
       "signal 'role_1': message 'IMU' of car.dbc has no signal 'yaw'; the nearest is 'Yaw'\n"},
      {[](auto& b) { b.bus = "can2"; },
       "signal 'role_1': there is no bus 'can2'; the nearest is 'can0'\n"},
      {[](auto& b) {
         b.valid_when.push_back({"Acx", 0.0});
       },
       "signal 'role_1': message 'IMU' of car.dbc has no signal 'Acx'; the nearest is 'Acc'\n"},
      {[](auto& b) { b.unit = Unit::rad_per_s; },
       "signal 'role_1': unit 'rad/s' contradicts 'deg/s' of signal 'IMU.Yaw' in car.dbc:4; fix "
       "one of them\n"},
      // an empty unit is no contradiction
      {[](auto& b) { b.signals = {"Counter"}, b.unit = Unit::rad; }, "taken\n"},
      {[](auto& b) {
         b.valid_when.push_back({"Counter", 16.0});
       },
       "signal 'Counter' never has the value 16; the nearest is 15"},
      {[](auto& b) { b.forward = 0.005; }, "signal 'Yaw' never has the value 0.005"},
      {[](auto& b) { b.forward = 1e-7; }, "never has the value 1e-07; the nearest is 0"},
      // 35 * 0.01 is 0.35000000000000003
      {[](auto& b) { b.forward = 0.354; }, "the nearest is 0.35\n"},
      {[](auto& b) { b.forward = b.reverse = 1.0; }, "forward and reverse are the same value"},
      {[](auto& b) { b.signals.clear(); }, "no signal is named"},
      {[](auto& b) { b.forward = 1.0, b.signals.push_back("Acc"); },
       "a direction comes from one signal"},
      {[](auto& b) { b.signals = {"CRC"}, b.unit = Unit::rpm; },
       "unit rpm needs the wheel's radius"},
      {[](auto& b) { b.signals = {"CRC"}, b.unit = Unit::rpm, b.radius_m = 0.1, b.ratio = 0.0; },
       "ratio must be a number other than 0"},
      {[](auto& b) { b.scale = HUGE_VAL; }, "not a finite"},
  };
  for (const auto& [change, error] : cases) {
    SignalBinding changed = bind(1, "IMU", "Yaw", Unit::deg_per_s);
    change(changed);
    EXPECT_THAT(refusal_of(changed), HasSubstr(error));
  }
  E2eBinding e2e = imu_protection();
  e2e.crc_signal = "CRK";
  EXPECT_THAT(refusal_of(bind(1, "IMU", "Yaw"), e2e), HasSubstr("nearest is 'CRC'"));
  e2e.message = "IMUU";
  EXPECT_EQ(refusal_of(bind(1, "IMU", "Yaw"), e2e),
            "end-to-end protection: no message 'IMUU' in car.dbc; the nearest is 'IMU'\n");
}

TEST(DecoderErrors, ReportUnusableUnitsAndFactors) {
  for (const auto& [scaling, error] :
       {std::pair{"(0.01,0) [0|0] \"mph\"",
                  "signal 'role_1': unit 'm/s' contradicts 'mph' of signal 'W.V' in car.dbc:2; "
                  "fix one of them, or use unit = \"1\" with a scale"},
        {"(0,0) [0|0] \"m/s\"",
         "signal 'role_1': signal 'V' has the factor 0 in car.dbc:2 and never changes; "
         "fix the database"},
        {"(0.01,0) [0|0] \"SED\"", ""}})
    EXPECT_EQ(refusal(parse_dbc(std::string("BO_ 1 W: 8 X\n SG_ V : 0|16@1+ ") + scaling + " X\n",
                                "car.dbc"),
                      {bind(1, "W", "V", Unit::m_per_s)}),
              error);
}

TEST(DecoderErrors, ReportIncompleteBindings) {
  const std::vector all{parse_dbc(car, "car.dbc")};
  const std::vector yaw{bind(1, "IMU", "Yaw")};
  EXPECT_THROW(Decoder(all, {}, std::vector(2, imu_protection()), {}), std::invalid_argument);
  EXPECT_THROW(Decoder({}, yaw, {}, {}), std::invalid_argument);
  EXPECT_THROW(Decoder(all, std::vector(max_samples_per_frame + 1, yaw[0]), {}, {}),
               std::invalid_argument);
}

}  // namespace
}  // namespace odomd::can::binding_errors_test
