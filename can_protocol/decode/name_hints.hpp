// Compares names of messages and signals word by word, to find the one that is meant: for
// proposals, and for hints in error messages about a name that the databases do not have.
#pragma once

#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "can_protocol/dbc/dbc.hpp"
#include "can_protocol/decode/signal_binding.hpp"

namespace odomd::can {

using NameWords = std::vector<std::string>;

/// The words in lower case: YawRate, YAW_RATE and yaw_rate are yaw and rate. A word begins after a
/// character that is not a letter, and at the second capital of "YawRate" or "WheelFL".
[[nodiscard]] NameWords words_of(std::string_view name);

/// Whether `shorter` is like "whl" for "wheel" or "acc" for "acceleration": at least three letters
/// of `longer` in their order, the first one included.
[[nodiscard]] bool abbreviates(std::string_view shorter, std::string_view longer);

/// For a message that no database has: "; the nearest is 'IMU'" if there is a similar name,
/// otherwise a signal of any message that fits the binding, otherwise how to list the messages.
[[nodiscard]] std::string message_hint(std::span<const Database> databases,
                                       const SignalBinding& binding);

/// The same for an end-to-end protection, which names no signal.
[[nodiscard]] std::string message_hint(std::span<const Database> databases,
                                       std::string_view message);

/// The same for a signal that its message does not have.
[[nodiscard]] std::string signal_hint(std::span<const Database> databases, const Message& message,
                                      const SignalBinding& binding, std::string_view signal);

/// Considers the signals of `message` only: "; the nearest is 'Yaw'", or nothing if it has none.
[[nodiscard]] std::string nearest_signal_hint(const Message& message, std::string_view signal);

}  // namespace odomd::can
