// Finds the valid name that is nearest to a misspelt one, for error messages.
#pragma once

#include <span>
#include <string>
#include <string_view>

namespace odomd {

/// The name with the fewest edits (insert, delete, replace, swap of neighbours; a change of case
/// counts a tenth) from `wanted`; the first of equally near names. Empty if there are no names.
[[nodiscard]] std::string_view nearest_name(std::string_view wanted,
                                            std::span<const std::string> names);

/// Whether one probably misspells the other: at most one edit, or two if both have 8 bytes or more.
[[nodiscard]] bool resembles(std::string_view a, std::string_view b);

/// The name that was probably meant, or none: the first that begins with `given` (if that has one
/// or two letters, only if no other name does), otherwise the nearest name if it resembles `given`.
[[nodiscard]] std::string_view likely_name(std::string_view given,
                                           std::span<const std::string> names);

/// "; the nearest is 'X'", or nothing if there are no names.
[[nodiscard]] std::string nearest_hint(std::string_view wanted, std::span<const std::string> names);

}  // namespace odomd
