// Hints for error messages: which name was probably meant by one that the databases do not have.
#pragma once

#include <span>
#include <string>
#include <string_view>

#include "can_protocol/dbc/dbc.hpp"
#include "can_protocol/decode/signal_binding.hpp"

namespace odomd::can {

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
