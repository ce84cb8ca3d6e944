// Measured numbers on a command line: "2985g", "29.3 N", "265mm", "15deg". A number without a unit
// is in the SI unit.
#pragma once

#include <cstdint>
#include <string_view>

namespace odomd::tools {

enum class Dimension : std::uint8_t { mass, length, angle, time, pure };

/// Newtons are a weight: see gravity_of().
enum class Unit : std::uint8_t { si, newton };

struct Quantity {
  double value = 0.0;  ///< SI; if the unit is newton, the weight
  Unit unit = Unit::si;
};

/// `option` is its name in messages: "--front". Throws std::invalid_argument if it is not a finite
/// number, or has a unit of another dimension.
[[nodiscard]] Quantity parse_quantity(std::string_view text, Dimension dimension,
                                      std::string_view option);

/// The same for a number that must be greater than 0, or 0 or greater; never in newtons.
[[nodiscard]] double parse_positive(std::string_view text, Dimension dimension,
                                    std::string_view option);
[[nodiscard]] double parse_not_negative(std::string_view text, Dimension dimension,
                                        std::string_view option);
/// `otherwise` if it is not given.
[[nodiscard]] double parse_or(double otherwise, std::string_view text, Dimension dimension,
                              std::string_view option);

/// The range of a quantity for any car, from a model to a lorry: outside it the unit is wrong.
struct Plausible {
  double from = 0.0;
  double to = 0.0;
};
[[nodiscard]] double parse_plausible(std::string_view text, Dimension dimension,
                                     std::string_view option, Plausible range);

}  // namespace odomd::tools
