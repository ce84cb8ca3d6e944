// Positions in the text of a TOML file that the parser does not keep, above all of comments.
#pragma once

#include <cstddef>
#include <string>
#include <string_view>
#include <vector>

namespace odomd::tools {

/// A line of the text, by offsets into it.
struct TomlLine {
  std::size_t begin = 0;
  std::size_t end = 0;                                ///< before the line break
  std::size_t comment = std::string_view::npos;       ///< of its '#', if it has a comment
  enum class Ends { plainly, inside_a_text } ends{};  ///< inside: of a text of several lines

  [[nodiscard]] bool has_comment() const { return comment != std::string_view::npos; }
};

/// The lines; never empty. The text must be TOML; a byte order mark is part of no line.
[[nodiscard]] std::vector<TomlLine> toml_lines(std::string_view text);

/// The offset of a position that the parser reported: line and character, both from 1.
[[nodiscard]] std::size_t toml_offset(std::string_view text, const std::vector<TomlLine>& lines,
                                      std::size_t line, std::size_t column);

/// The index of the line that an offset lies in.
[[nodiscard]] std::size_t toml_line_of(const std::vector<TomlLine>& lines, std::size_t offset);

/// Puts a note into the comment at the end of the line of an offset, as "(note)" or "(label:
/// note)", replacing an earlier note of odom with that label; an empty note removes it. Everything
/// else in the comment is kept.
void set_toml_note(std::string& text, std::size_t offset, const std::string& label,
                   const std::string& note);

/// odom's note with that label in the comment at the end of the line of an offset, without brackets
/// and label; empty if there is none.
[[nodiscard]] std::string toml_note(const std::string& text, std::size_t offset,
                                    const std::string& label);

/// A key as written in a file: in quotes if necessary.
[[nodiscard]] std::string toml_key(std::string_view key);

}  // namespace odomd::tools
