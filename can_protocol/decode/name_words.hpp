// Splits names of messages and signals into words, and finds the dimension of a unit. Hints and
// proposals use both to find the signal that is meant.
#pragma once

#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

#include "can_protocol/decode/signal_binding.hpp"

namespace odomd::can {

using NameWords = std::vector<std::string>;

/// The words in lower case: YawRate, YAW_RATE and yaw_rate are yaw and rate. A word begins after
/// anything but a letter, and at the second capital of "YawRate" or "WheelFL".
[[nodiscard]] NameWords words_of(std::string_view name);

/// Whether `shorter` is like "whl" for "wheel" or "acc" for "acceleration": at least three letters
/// of `longer` in their order, the first one included.
[[nodiscard]] bool abbreviates(std::string_view shorter, std::string_view longer);

enum class Dimension : std::uint8_t { none, angle, angular_rate, speed, acceleration };

[[nodiscard]] Dimension dimension_of(Unit unit) noexcept;

}  // namespace odomd::can
