// Lines of the text of a TOML file and odom's notes in their comments, which no parser keeps. Each
// line is read on its own; the caller parses the result to detect a change inside a multi-line
// string.
#pragma once

#include <cstddef>
#include <string>
#include <string_view>

namespace odomd::tools {

/// The line that contains an offset: its begin, its comment (at the end if there is none), and its
/// end without the line break.
struct TomlLine {
  std::size_t begin = 0;
  std::size_t comment = 0;
  std::size_t end = 0;
};
[[nodiscard]] TomlLine toml_line(std::string_view text, std::size_t offset);

/// The offset of a position that the parser reported: line and character, both from 1.
[[nodiscard]] std::size_t toml_offset(std::string_view text, std::size_t line, std::size_t column);

/// Puts a note into the comment that ends the line with this offset, as "(note)" or "(label:
/// note)", replacing an earlier note of odom with that label; an empty note removes it. Everything
/// else in the comment is kept.
void set_toml_note(std::string& text, std::size_t offset, const std::string& label,
                   const std::string& note);

/// odom's note with that label in the comment that ends the line with this offset, without brackets
/// and label; empty if there is none.
[[nodiscard]] std::string toml_note(const std::string& text, std::size_t offset,
                                    const std::string& label);

/// A key as written in a file: in quotes if necessary.
[[nodiscard]] std::string toml_key(std::string_view key);

}  // namespace odomd::tools
