// What comes from outside (arguments, files, names of databases, the environment) as messages show
// it: on one line, without a character that a terminal obeys, and no longer than is read.
#pragma once

#include <cstddef>
#include <cstdint>
#include <string>
#include <string_view>

namespace odomd {

enum class LineBreaks : std::uint8_t { escaped, kept };

/// UTF-8 as it is, but for control characters (C0, DEL, C1) and those that turn the direction of
/// writing, which become \n, \t or \u001b, and bytes that are no UTF-8, which become \xff. In JSON
/// the result means the same. `kept` keeps newlines and tabs.
[[nodiscard]] std::string escaped(std::string_view text,
                                  LineBreaks line_breaks = LineBreaks::escaped);

/// The first `longest` bytes of it, never a part of a character, and "…" where there are more.
[[nodiscard]] std::string shortened(std::string_view text, std::size_t longest);

/// "text" in quotes, escaped, shortened to 60 bytes.
[[nodiscard]] std::string quoted(std::string_view text);

/// A message as one line: escaped, and where it is longer than 1,000 bytes with "…" in place of its
/// middle. The end mostly says what to do.
[[nodiscard]] std::string one_line(std::string_view message);

}  // namespace odomd
