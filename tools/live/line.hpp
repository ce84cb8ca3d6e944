// Lines of styled text: what is drawn, before a terminal or a pipe is known.
#pragma once

#include <cstddef>
#include <string>
#include <vector>

namespace odomd::tools {

enum class Style { plain, dim, strong, good, warning, bad, accent };

struct Span {
  std::string text;  ///< UTF-8, every character one column wide
  Style style = Style::plain;
};

using Line = std::vector<Span>;
using Lines = std::vector<Line>;

/// Which characters the terminal can show.
enum class Glyphs { unicode, ascii };

enum class Colour { on, off };

[[nodiscard]] std::size_t width(const Line& line);

/// Cut or filled with blanks to so many columns.
[[nodiscard]] Line fitted(const Line& line, std::size_t columns);

/// `left` at the beginning, `right` at the end of so many columns; `right` gives way.
[[nodiscard]] Line justified(Line left, const Line& right, std::size_t columns);

/// Two blocks side by side: `left` filled to `columns`.
[[nodiscard]] Lines side_by_side(const Lines& left, const Lines& right, std::size_t columns);

/// Without styles, without blanks at the end.
[[nodiscard]] std::string as_text(const Line& line);

/// With the terminal's own sixteen colours, so that its theme holds; without colours bold and dim
/// are left.
[[nodiscard]] std::string as_ansi(const Line& line, Colour colour);

}  // namespace odomd::tools
