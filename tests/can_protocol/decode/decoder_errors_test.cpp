// Bindings that the decoder refuses: the error names the role, the nearest name and the fix.
#include "can_protocol/decode/decoder.hpp"
#include "tests/can_protocol/decode/one_binding.hpp"
#include "tests/gtest.hpp"

namespace odomd::can::decoder_errors_test {
namespace {

std::string refusal_of(const SignalBinding& binding, const E2eBinding& e2e = imu_protection()) {
  const std::vector<Database> databases{parse_dbc(car, "car.dbc")};
  const std::vector<std::string> buses{"can0", "can1"};
  const std::string text = message_of(
      [&] { const Decoder decoder(databases, std::vector{binding}, std::vector{e2e}, buses); });
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
    SignalBinding binding = bind(1, "IMU", "Yaw", Unit::deg_per_s);
    change(binding);
    EXPECT_THAT(refusal_of(binding), HasSubstr(error));
  }
  E2eBinding e2e = imu_protection();
  e2e.crc_signal = "CRK";
  EXPECT_THAT(refusal_of(bind(1, "IMU", "Yaw"), e2e), HasSubstr("nearest is 'CRC'"));
  e2e.message = "IMUU";
  EXPECT_EQ(refusal_of(bind(1, "IMU", "Yaw"), e2e),
            "end-to-end protection: no message 'IMUU' in car.dbc; the nearest is 'IMU'\n");
}

TEST(DecoderErrors, ReportUnitsAndFactorsThatNoValueComesOutOf) {
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
  const std::vector databases{parse_dbc(car, "car.dbc")};
  const std::vector yaw{bind(1, "IMU", "Yaw")};
  EXPECT_THROW(Decoder(databases, {}, std::vector(2, imu_protection()), {}), std::invalid_argument);
  EXPECT_THROW(Decoder({}, yaw, {}, {}), std::invalid_argument);
  EXPECT_THROW(Decoder(databases, std::vector(max_samples_per_frame + 1, yaw[0]), {}, {}),
               std::invalid_argument);
}

}  // namespace
}  // namespace odomd::can::decoder_errors_test
