// The valid name that a misspelt one is nearest to, for error messages.
#pragma once

#include <span>
#include <string>
#include <string_view>

namespace odomd {

/// The name with the fewest edits (insert, delete, replace, swap of neighbours; a change of case
/// counts a tenth) from `wanted`; the first of equals. Empty if there are no names.
[[nodiscard]] std::string_view nearest_name(std::string_view wanted,
                                            std::span<const std::string> names);

/// Whether one is likely the other misspelt: an edit or two, the second from eight characters on.
[[nodiscard]] bool resembles(std::string_view a, std::string_view b);

/// The name that someone likely meant: one that begins with what was given (the only one, where
/// that is a letter or two), else the nearest where it resembles that. Empty if there is none such.
[[nodiscard]] std::string_view likely_name(std::string_view given,
                                           std::span<const std::string> names);

/// "; the nearest is 'X'", or nothing if there are no names.
[[nodiscard]] std::string nearest_hint(std::string_view wanted, std::span<const std::string> names);

}  // namespace odomd
