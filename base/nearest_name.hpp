// Finds the valid name that is nearest to a misspelt one, for error messages.
#pragma once

#include <span>
#include <string>
#include <string_view>

namespace odomd {

/// The name with the fewest edits (insert, delete, replace, swap of neighbours; a change of case
/// counts a tenth) from `wanted`; the first of equals. Empty if there are no names.
[[nodiscard]] std::string_view nearest_name(std::string_view wanted,
                                            std::span<const std::string> names);

/// Whether one is probably a misspelling of the other: one edit, or two from eight characters on.
[[nodiscard]] bool resembles(std::string_view a, std::string_view b);

/// The name that was probably meant: one that begins with the input (the only one, if the input has
/// one or two letters), else the nearest one if it resembles the input. Empty if there is none.
[[nodiscard]] std::string_view likely_name(std::string_view given,
                                           std::span<const std::string> names);

/// "; the nearest is 'X'", or nothing if there are no names.
[[nodiscard]] std::string nearest_hint(std::string_view wanted, std::span<const std::string> names);

}  // namespace odomd
