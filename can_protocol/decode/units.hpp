// Units of physical values: the spellings that databases have for them, and their size in SI.
#pragma once

#include <optional>
#include <string_view>

#include "can_protocol/decode/signal_binding.hpp"

namespace odomd::can {

/// What a database's unit text means; nothing where it is empty or none of ours. Case, blanks and
/// the spelling of signs do not count: "m/s^2", "m/s2", "m/s²", "kph", "°/s", "1/min".
[[nodiscard]] std::optional<Unit> unit_of_text(std::string_view text);

/// Whether it is a unit that is none of ours, so that a value in it cannot be meant: "mph", "%".
[[nodiscard]] bool is_other_unit(std::string_view text);

/// As a configuration spells it: "m/s2".
[[nodiscard]] std::string_view unit_name(Unit unit) noexcept;

/// What a physical value is multiplied by to be in SI. For rpm that of an angular velocity: rad/s.
[[nodiscard]] double si_factor(Unit unit) noexcept;

}  // namespace odomd::can
