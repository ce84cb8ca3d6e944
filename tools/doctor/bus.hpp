// Examines CAN buses: whether an interface can receive the car's frames, and whether its traffic
// matches the configuration and the databases.
#pragma once

#include <chrono>
#include <cstdint>
#include <filesystem>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "can_protocol/dbc/dbc.hpp"
#include "can_protocol/frame.hpp"
#include "can_protocol/sources/controller.hpp"
#include "daemon/core/config.hpp"
#include "daemon/diagnostics/diagnostic.hpp"
#include "tools/replay/drive.hpp"

namespace odomd::tools::doctor {

/// A network interface.
struct Link {
  bool is_can = true;
  bool is_up = true;
  bool carries_fd = false;                    ///< CAN FD frames
  std::optional<can::Controller> controller;  ///< none: a virtual interface
};

/// Nothing if there is no such interface. Not thread-safe, like can::read_controller().
[[nodiscard]] std::optional<Link> read_link(const std::string& interface);

/// CAN FD if a mapped message needs it.
[[nodiscard]] can::FrameProtocol needed_protocol(const daemon::Config& config,
                                                 std::span<const can::Database> databases);

[[nodiscard]] diagnostics::Diagnostics examine_link(
    const std::string& interface, const std::optional<Link>& link,
    can::FrameProtocol needed = can::FrameProtocol::classic);

/// Records interfaces for a time, or until an interrupt, as a drive without camera and reference
/// whose clock is CLOCK_MONOTONIC. Throws std::invalid_argument or std::system_error for a wrong
/// configuration or interface.
[[nodiscard]] Drive listen(const std::filesystem::path& config,
                           const std::vector<std::string>& interfaces,
                           std::chrono::seconds duration);

/// The frames of one identifier.
struct Identifier {
  std::string bus;
  std::uint32_t id = 0;
  can::IdFormat format = can::IdFormat::standard;
  std::uint64_t frames = 0;
  double rate_hz = 0.0;  ///< 0: a single frame
  std::string message;   ///< name of the mapped message; empty: not mapped
};

/// All received identifiers, ordered by bus and identifier, for a table with the unmapped ones.
[[nodiscard]] std::vector<Identifier> identifiers_of(const Drive& drive);

/// Reports a listen-only interface that receives nothing, or only one frame repeatedly: if
/// no node acknowledges a frame, its sender repeats it without a pause, and stays on the bus.
[[nodiscard]] diagnostics::Diagnostics examine_acknowledgement(const std::string& interface,
                                                               const Link& link,
                                                               const Drive& heard);

/// Reports that no frame came, or mapped messages that are missing, have the other format of
/// identifier or another rate, are too short, or fail their protection.
[[nodiscard]] diagnostics::Diagnostics examine_traffic(const Drive& drive);

}  // namespace odomd::tools::doctor
