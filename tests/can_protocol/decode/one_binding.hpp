// A binding of one signal, the decoder's error for it, and a car's database.
#pragma once

#include <string>
#include <utility>
#include <vector>

#include "can_protocol/decode/decoder.hpp"
#include "tests/scratch.hpp"

namespace odomd::can {

inline SignalBinding binding_of(std::string message, std::string signal,
                                std::uint16_t channel = 0) {
  return {.channel = channel,
          .role = "role_" + std::to_string(channel),
          .message = std::move(message),
          .signals = {std::move(signal)}};
}

/// Why the bindings are refused; empty if accepted.
inline std::string refusal(const Database& database, const std::vector<SignalBinding>& bindings,
                           const std::vector<E2eBinding>& protections = {},
                           const std::vector<std::string>& buses = {}) {
  return message_of([&] { const Decoder decoder({&database, 1}, bindings, protections, buses); });
}

inline constexpr const char* car = R"(BO_ 416 IMU: 8 X
 SG_ CRC : 0|8@1+ (1,0) [0|0] "" X
 SG_ Counter : 8|4@1+ (1,0) [0|0] "" X
 SG_ Yaw : 16|16@1- (0.01,0) [0|0] "deg/s" X
 SG_ Acc : 32|16@1- (0.001,0) [0|0] "g" X
BO_ 2147484064 WHEELS: 8 X
 SG_ Left : 0|16@1+ (0.1,0) [0|0] "km/h" X
 SG_ Right : 16|16@1+ (0.1,0) [0|0] "km/h" X
 SG_ Fault : 32|2@1+ (1,0) [0|0] "" X
BO_ 32 STEER: 4 X
 SG_ Angle : 7|12@0- (1.5,0) [0|0] "deg" X
 SG_ Fraction : 11|4@0- (0.1,0) [0|0] "deg" X
 SG_ Gear : 16|3@1+ (1,0) [0|0] "" X
BO_ 33 MIXED: 3 X
 SG_ Page M : 0|4@1+ (1,0) [0|0] "" X
 SG_ Speed m2 : 8|8@1+ (0.5,-10) [0|0] "m/s" X
 SG_ Other m3 : 8|16@1+ (1,0) [0|0] "" X
 SG_ Lost m : 8|8@1+ (1,0) [0|0] "" X
BA_DEF_DEF_ "GenMsgCycleTime" 0;
BA_ "GenMsgCycleTime" BO_ 416 5;
)";

inline SignalBinding bind(std::uint16_t channel, std::string message, std::string signal,
                          Unit unit = Unit::none) {
  SignalBinding binding = binding_of(std::move(message), std::move(signal), channel);
  binding.unit = unit;
  return binding;
}

/// Protects the message IMU of `car`.
inline E2eBinding imu_protection() {
  return {.message = "IMU",
          .profile = E2eProfile::p01,
          .data_id = 0x1A0,
          .crc_signal = "CRC",
          .counter_signal = "Counter"};
}

}  // namespace odomd::can
