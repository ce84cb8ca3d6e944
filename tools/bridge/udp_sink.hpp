// Poses as JSON over UDP, one object per datagram, for PlotJuggler's UDP server.
#pragma once

#include <memory>
#include <string>

#include "tools/bridge/sample.hpp"

namespace odomd::tools {

/// The address that PlotJuggler listens on by default.
inline constexpr const char* plotjuggler_address = "127.0.0.1:9870";

/// {"timestamp": seconds, "odomd": {"tick": ..., "map": {"x": ...}, ..., "mode_name": "tracking"}},
/// names and units as in pose_fields.hpp.
[[nodiscard]] std::string sample_json(const BridgeSample& sample);

/// Sends to HOST:PORT ([::1]:9870 for IPv6). Nobody needs to listen. Throws std::invalid_argument
/// for an invalid address, std::runtime_error for an unknown host.
[[nodiscard]] std::unique_ptr<Sink> open_udp(const std::string& address);

}  // namespace odomd::tools
