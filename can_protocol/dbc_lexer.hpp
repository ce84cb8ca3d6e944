// Cuts the text of a DBC into words, quoted texts and punctuation, and remembers their lines.
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
  end           ///< of the file
};

struct Token {
  TokenKind kind = TokenKind::end;
  std::string text;
  std::uint32_t line = 0;
  bool starts_line = false;  ///< nothing but blanks before it on its line
};

/// The tokens of UTF-8 `text`, closed by one of kind `end`. Throws DbcError for a quoted text that
/// never ends and for bytes that no text has.
[[nodiscard]] std::vector<Token> tokenize(std::string_view text, const std::string& file_name);

/// How a message shows a token: 'word', a shortened "text", end of file.
[[nodiscard]] std::string show(const Token& token);

/// "file:line: text"
[[nodiscard]] std::string at_line(const std::string& file_name, std::uint32_t line,
                                  std::string_view text);

}  // namespace odomd::can
