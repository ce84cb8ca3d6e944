// Receives the traffic of CAN interfaces for a while.
#pragma once

#include <chrono>
#include <string>
#include <vector>

#include "can_protocol/bus_names.hpp"
#include "can_protocol/frame.hpp"

namespace odomd::tools {

/// All frames until the time is over or an interrupt comes, in the order of their stamps [ns,
/// CLOCK_MONOTONIC]; Frame::bus is the index in `buses`, to which the interfaces are added.
/// `receive_buffer` is the kernel's buffer per interface [bytes]. Throws std::invalid_argument for
/// a missing interface and for too many, std::system_error if one cannot be opened.
[[nodiscard]] std::vector<can::Frame> listen(const std::vector<std::string>& interfaces,
                                             can::BusNames& buses, int receive_buffer,
                                             std::chrono::duration<double> duration);

}  // namespace odomd::tools
