// Makes external text (arguments, files, names in databases, the environment) printable for
// messages: on one line, without terminal control characters, and of limited length.
#pragma once

#include <cstddef>
#include <cstdint>
#include <string>
#include <string_view>

namespace odomd {

enum class LineBreaks : std::uint8_t { escaped, kept };

/// Writes control characters (C0, DEL, C1) and those that change the direction of text as \n, \t or
/// \u001b, and invalid UTF-8 as \xff; keeps all other UTF-8. Escaping a JSON text does not change
/// its meaning. `kept` keeps newlines and tabs.
[[nodiscard]] std::string escaped(std::string_view text,
                                  LineBreaks line_breaks = LineBreaks::escaped);

/// The first `longest` bytes without splitting a character, and "…" if there are more.
[[nodiscard]] std::string shortened(std::string_view text, std::size_t longest);

/// "text" in quotes, escaped, shortened to 60 bytes.
[[nodiscard]] std::string quoted(std::string_view text);

/// A message as one line: escaped, and with "…" instead of its middle when it is longer than 1,000
/// bytes. The end is kept: it usually says what to do.
[[nodiscard]] std::string one_line(std::string_view message);

}  // namespace odomd
