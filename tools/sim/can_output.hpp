// The output of live frames: to a CAN interface, or as candump lines to standard output.
#pragma once

#include <cstdint>
#include <span>
#include <string>

#include "base/file_descriptor.hpp"
#include "can_protocol/frame.hpp"
#include "can_protocol/sources/candump.hpp"

namespace odomd::sim {

class CanOutput {
 public:
  /// `name` is an interface, or "-" for standard output. Throws std::invalid_argument if there is
  /// no such interface, std::runtime_error if it cannot be opened.
  CanOutput(const std::string& name, can::StampDecimals decimals);

  /// Sends all frames immediately. Throws std::runtime_error if they cannot be sent: nobody reads
  /// or acknowledges, or the interface is down.
  void send(std::span<const can::Frame> frames);

 private:
  void transmit(const can::Frame& frame);

  std::string name_;
  can::StampDecimals decimals_;
  FileDescriptor socket_;  // not open for standard output
  std::string text_;
};

/// The name of the bus in a log.
inline constexpr const char* log_interface = "can0";

}  // namespace odomd::sim
