// Makes external text (arguments, files, names in databases, the environment) valid UTF-8, and
// printable for messages: on one line, without terminal control characters, and of limited length.
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

struct Character {
  std::uint32_t code = 0;
  std::size_t length = 0;  ///< bytes; 0: not UTF-8
};

/// The character that begins at this byte; `at` is less than the text's size.
[[nodiscard]] Character character_at(std::string_view text, std::size_t at);

/// Whether a byte continues a character of UTF-8.
[[nodiscard]] bool is_continuation(char byte);

[[nodiscard]] bool is_utf8(std::string_view text);

/// UTF-8 without a byte order mark. Text that is not valid UTF-8 is read as Windows-1252, the
/// superset of Latin-1 that DBC editors and spreadsheets write. Never fails.
[[nodiscard]] std::string to_utf8(std::string_view text);

}  // namespace odomd
