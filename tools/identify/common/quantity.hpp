// Measured numbers on a command line: "2985g", "265mm", "15deg". Without a unit they are in SI
// units.
#pragma once

#include <cstdint>
#include <string>
#include <string_view>

#include "tools/cli/command.hpp"

namespace odomd::tools {

enum class Dimension : std::uint8_t { mass, length, angle, time, pure };

/// `option` is the option's name in messages: "--front". Throws std::invalid_argument if the text
/// is not a finite number, or has a unit of another dimension.
[[nodiscard]] double parse_quantity(std::string_view text, Dimension dimension,
                                    std::string_view option);

/// Like parse_quantity(), for a number that must be positive, or not negative.
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

}  // namespace odomd::tools
