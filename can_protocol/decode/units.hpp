// Units of physical values: their spellings in databases, their factors to SI and their dimensions.
#pragma once

#include <cstdint>
#include <optional>
#include <string_view>

#include "can_protocol/decode/signal_binding.hpp"

namespace odomd::can {

/// The unit that a text in a database means; empty when the text is empty or unknown. Ignores case,
/// blanks and the spelling of signs and words: "m/s^2", "m/s²", "kph", "°/s", "1/min",
/// "Unit_KiloMeterPerHour".
[[nodiscard]] std::optional<Unit> unit_of_text(std::string_view text);

/// Whether the text is a unit that no role's quantity can have: "mph", "Nm", "%".
[[nodiscard]] bool is_other_unit(std::string_view text);

/// The spelling in a configuration: "m/s2".
[[nodiscard]] std::string_view unit_name(Unit unit) noexcept;

/// Whether a unit is in turns per minute (revolutions), or any unit of angular velocity (rotation).
[[nodiscard]] constexpr bool is_revolutions(Unit unit) noexcept {
  return unit == Unit::rpm || unit == Unit::erpm;
}
[[nodiscard]] constexpr bool is_rotation(Unit unit) noexcept {
  return is_revolutions(unit) || unit == Unit::rad_per_s || unit == Unit::deg_per_s;
}

/// The factor from a physical value to SI. For rpm it gives an angular velocity in rad/s.
[[nodiscard]] double si_factor(Unit unit) noexcept;

/// The dimension of the quantity in SI: turns per minute give a speed, since they need a radius.
enum class Dimension : std::uint8_t { none, angle, angular_rate, speed, acceleration };
[[nodiscard]] Dimension dimension_of(Unit unit) noexcept;

}  // namespace odomd::can
