// Poses as JSON over UDP, an object a datagram: PlotJuggler's UDP server reads it.
#pragma once

#include <memory>
#include <string>

#include "tools/bridge/sample.hpp"

namespace odomd::tools {

/// Where PlotJuggler listens unless it is told otherwise.
inline constexpr const char* plotjuggler_address = "127.0.0.1:9870";

/// {"timestamp": seconds, "odomd": {"tick": ..., "map": {"x": ...}, ..., "mode_name": "tracking"}},
/// names and units as in pose_fields.hpp.
[[nodiscard]] std::string sample_json(const BridgeSample& sample);

/// Sends to HOST:PORT ([::1]:9870 for IPv6). Nobody needs to listen. Throws std::invalid_argument
/// for an address that is none, std::runtime_error for a host that nobody knows.
[[nodiscard]] std::unique_ptr<Sink> open_udp(const std::string& address);

}  // namespace odomd::tools
