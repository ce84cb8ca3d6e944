// The output of live frames: a CAN interface, or as candump lines onto standard output.
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
  /// `name` is an interface, or "-" for standard output. Throws std::invalid_argument where there
  /// is no such interface, std::runtime_error where it cannot be opened.
  CanOutput(const std::string& name, can::StampDecimals decimals);

  /// Sends the frames, all at once. Throws std::runtime_error if they cannot be sent: nobody reads
  /// or acknowledges, or the interface is down.
  void send(std::span<const can::Frame> frames);

 private:
  void transmit(const can::Frame& frame);

  std::string name_;
  can::StampDecimals decimals_;
  FileDescriptor socket_;  // none for standard output
  std::string text_;
};

/// Name that a log gives the bus.
inline constexpr const char* log_interface = "can0";

}  // namespace odomd::sim
