// Determines the kind of a CAN source from its name, and opens it.
#pragma once

#include <cstdint>
#include <memory>
#include <string>

#include "can_protocol/bus_names.hpp"
#include "can_protocol/sources/frame_source.hpp"
#include "can_protocol/sources/log_clock.hpp"
#include "can_protocol/sources/log_stamps.hpp"
#include "can_protocol/sources/socketcan.hpp"

namespace odomd::can {

enum class SourceKind : std::uint8_t { standard_input, log, interface };

/// "-" is standard input. A name with a '/' or ending in ".log" is a log, and so is the name of a
/// file or FIFO, unless an interface has the same name. Everything else is an interface. Throws
/// std::invalid_argument for a name that can be neither.
[[nodiscard]] SourceKind source_kind(const std::string& name);

/// Opens a source for the live daemon. `buses` numbers the interface, or the interfaces of the log;
/// `clock` maps the stamps of logs. Both must outlive the source. `settings`, except for the bus,
/// apply to an interface; only `selected` frames of a log are read. Throws as LogFeeder and
/// SocketCanSource do, and std::invalid_argument at one bus too many.
[[nodiscard]] std::unique_ptr<FrameSource> open_source(const std::string& name, BusNames& buses,
                                                       LogClock& clock, SocketCanSettings settings,
                                                       const FrameSelection& selected = {});

}  // namespace odomd::can
