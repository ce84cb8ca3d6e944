// A database while it is read: messages whose multiplexing is still as it was written.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "can_protocol/dbc.hpp"
#include "can_protocol/dbc_cursor.hpp"

namespace odomd::can {

/// What SG_ (`m3`) and SG_MUL_VAL_ say of one signal.
struct DraftMultiplexing {
  std::optional<std::uint64_t> selected_by;
  std::string multiplexor;
  std::vector<MultiplexRange> ranges;
};

struct DraftMessage {
  Message message;
  std::vector<DraftMultiplexing> multiplexing;  ///< by signal
  std::optional<double> cycle_time_ms;
  std::optional<std::string> frame_format;
};

/// Finds every multiplexed signal's multiplexor. Throws DbcError where that is not clear.
void resolve_multiplexing(DraftMessage& draft, DbcCursor& cursor);

/// Warns of signals that lie beyond the payload or on top of one another.
void warn_of_misfits(const Message& message, DbcCursor& cursor);

}  // namespace odomd::can
