// Measured numbers on a command line: "2985g", "29.3 N", "265mm", "15deg". Without a unit they are
// in the SI unit.
#pragma once

#include <cstdint>
#include <string>
#include <string_view>

#include "tools/cli/command.hpp"
#include "tools/identify/common/measured.hpp"

namespace odomd::tools {

enum class Dimension : std::uint8_t { mass, length, angle, time, pure };

/// Newtons are a weight: see gravity_of().
enum class Unit : std::uint8_t { si, newton };

struct Quantity {
  double value = 0.0;  ///< SI; if the unit is newton, the weight
  Unit unit = Unit::si;
};

/// `option` is the option's name in messages: "--front". Throws std::invalid_argument if the text
/// is not a finite number, or has a unit of another dimension.
[[nodiscard]] Quantity parse_quantity(std::string_view text, Dimension dimension,
                                      std::string_view option);

/// Like parse_quantity(), for a number that must be positive, or not negative; never in newtons.
[[nodiscard]] double parse_positive(std::string_view text, Dimension dimension,
                                    std::string_view option);
[[nodiscard]] double parse_not_negative(std::string_view text, Dimension dimension,
                                        std::string_view option);
/// The number, or `otherwise` if the text is empty.
[[nodiscard]] double parse_or(double otherwise, std::string_view text, Dimension dimension,
                              std::string_view option);

/// The range of a quantity for any car, from a model to a lorry; outside it the unit must be wrong.
struct Plausible {
  double from = 0.0;
  double to = 0.0;
};
[[nodiscard]] double parse_plausible(std::string_view text, Dimension dimension,
                                     std::string_view option, Plausible range);

/// --measured, for the methods that use scale, tape and stop-watch. Add it before other options.
void add_measured_option(Command method);

/// --gravity: the local value, or the Earth's mean with its spread.
void add_gravity_option(Command method, std::string& gravity);
[[nodiscard]] Measured gravity_of(const std::string& gravity);

}  // namespace odomd::tools
