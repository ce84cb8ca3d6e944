// Names of messages and signals as words, and what a unit measures: how hints and proposals find
// out which signal is meant.
#pragma once

#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

#include "can_protocol/decode/signal_binding.hpp"

namespace odomd::can {

using NameWords = std::vector<std::string>;

/// In lower case: YawRate, YAW_RATE and yaw_rate are the words yaw and rate. A word begins behind
/// anything but a letter, and at the hump of "YawRate" or "WheelFL".
[[nodiscard]] NameWords words_of(std::string_view name);

/// "whl" of "wheel", "acc" of "acceleration": at least three letters, in order, the first ones
/// alike.
[[nodiscard]] bool abbreviates(std::string_view shorter, std::string_view longer);

enum class Dimension : std::uint8_t { none, angle, angular_rate, speed, acceleration };

[[nodiscard]] Dimension dimension_of(Unit unit) noexcept;

}  // namespace odomd::can
