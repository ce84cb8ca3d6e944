// Splits the text of a DBC into words, quoted texts and punctuation, with their lines.
#pragma once

#include <cstddef>
#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

namespace odomd::can {

enum class TokenKind : std::uint8_t {
  word,         ///< a name, keyword or number, also "1+" and "0-5"
  text,         ///< "in quotes", without them
  punctuation,  ///< one other character
  broken,       ///< an error: `text` says why, and only `end` follows
  end           ///< of the file
};

struct Token {
  TokenKind kind = TokenKind::end;
  std::string text;
  std::uint32_t line = 0;
  bool starts_line = false;  ///< nothing but blanks before it on its line
};

/// The tokens of UTF-8 `text`, ended by one of kind `end`; a comment from `//` to the end of its
/// line is none. A quoted text that never ends, or a binary byte, becomes a broken token, so that
/// an error before it, such as a missing quote, is reported first.
[[nodiscard]] std::vector<Token> tokenize(std::string_view text);

/// How a message shows a token: 'word', a shortened "text", end of file.
[[nodiscard]] std::string show(const Token& token);

/// "file:line: text"
[[nodiscard]] std::string at_line(const std::string& file_name, std::uint32_t line,
                                  std::string_view text);

}  // namespace odomd::can
