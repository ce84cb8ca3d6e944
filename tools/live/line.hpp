// Lines of styled text, independent of whether they go to a terminal or a pipe.
#pragma once

#include <cstddef>
#include <string>
#include <vector>

namespace odomd::tools {

enum class Style { plain, dim, strong, good, warning, bad, accent };

struct StyledText {
  std::string text;  ///< UTF-8, every character one column wide
  Style style = Style::plain;
};

using Line = std::vector<StyledText>;
using Lines = std::vector<Line>;

enum class Colour { on, off };

[[nodiscard]] std::size_t width(const Line& line);

/// The line, cut or filled with blanks to `columns`.
[[nodiscard]] Line fitted(const Line& line, std::size_t columns);

/// `left` at the beginning of `columns`, `right` at the end; without `right` if both do not fit.
[[nodiscard]] Line justified(Line left, const Line& right, std::size_t columns);

/// Two blocks side by side: `left` filled to `columns`.
[[nodiscard]] Lines side_by_side(const Lines& left, const Lines& right, std::size_t columns);

/// The text without styles and without blanks at the end.
[[nodiscard]] std::string as_text(const Line& line);
[[nodiscard]] std::string as_text(const Lines& lines);

/// Uses the terminal's own sixteen colours, so that its theme applies; without colours only bold
/// and dim remain.
[[nodiscard]] std::string as_ansi(const Line& line, Colour colour);

}  // namespace odomd::tools
