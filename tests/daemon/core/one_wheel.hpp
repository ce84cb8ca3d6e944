// A car whose bus has one message with one signal: the speed of the rear wheels.
#pragma once

#include <vector>

#include "can_protocol/dbc/dbc.hpp"
#include "daemon/core/config.hpp"

namespace odomd::daemon::one_wheel {

inline std::vector<can::SignalBinding> bindings() {
  return {{.channel = static_cast<std::uint16_t>(estimator::Source::wheel_rear),
           .role = "wheel_rear",
           .message = "WHEEL",
           .signals = {"Speed"},
           .unit = can::Unit::m_per_s}};
}

inline std::vector<can::Database> bus() {
  return {can::parse_dbc("BO_ 257 WHEEL: 2 Car\n SG_ Speed : 0|16@1- (0.001,0) [0|0] \"m/s\" X\n",
                         "test.dbc")};
}

}  // namespace odomd::daemon::one_wheel
