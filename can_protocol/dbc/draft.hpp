// A database while it is read: its multiplexing is not resolved yet.
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>
#include <unordered_map>
#include <vector>

#include "can_protocol/dbc/cursor.hpp"
#include "can_protocol/dbc/dbc.hpp"

namespace odomd::can {

/// A signal's multiplexing from SG_ (`m3`) and SG_MUL_VAL_, and whether the signal is usable.
struct DraftSignal {
  bool left_out = false;
  bool marked = false;  ///< `m`, with or without a number
  std::optional<std::uint64_t> selected_by;
  std::string multiplexor;
  std::vector<MultiplexRange> ranges;
};

struct DraftMessage {
  Message message;
  std::vector<DraftSignal> signals;                      ///< of the message
  std::unordered_map<std::string, std::size_t> by_name;  ///< indices of the signals
  std::optional<double> cycle_time_ms;
  std::optional<std::string> frame_format;  ///< VFrameFormat
};

/// The signal's index, or nothing.
[[nodiscard]] std::optional<std::size_t> find_signal(const DraftMessage& draft,
                                                     const std::string& name);

/// The remaining budget of comparisons in a file: the pairs of signals and of their multiplexor
/// values grow quadratically.
class Effort {
 public:
  explicit Effort(std::size_t comparisons) : left_(comparisons) {}

  /// False once the effort is used up, including the call that uses it up.
  bool spend(std::size_t comparisons) {
    left_ = comparisons > left_ ? 0 : left_ - comparisons;
    return left_ > 0;
  }

 private:
  std::size_t left_;
};

/// Leaves out a signal that cannot be used, with one warning.
void leave_out(DraftMessage& draft, std::size_t signal, std::uint32_t line, const std::string& why,
               DbcCursor& cursor);

/// Finds the multiplexor of every multiplexed signal, and leaves out signals that do not fit the
/// payload and those whose multiplexing is not clear.
void resolve_signals(DraftMessage& draft, DbcCursor& cursor);

/// Warns of overlapping signals while there is effort left.
void warn_of_overlaps(const Message& message, Effort& effort, DbcCursor& cursor);

}  // namespace odomd::can
