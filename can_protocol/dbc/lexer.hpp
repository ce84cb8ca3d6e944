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
  text,         ///< "in quotes", without the quotes
  punctuation,  ///< one other character
  broken,       ///< a mistake, described in `text`; the rest of the line is lost
  cut,          ///< a text that the file's end cuts off; `text` is the error, only `end` follows
  end           ///< end of the file
};

struct Token {
  TokenKind kind = TokenKind::end;
  std::string text;
  std::uint32_t line = 0;
  bool starts_line = false;  ///< nothing but blanks before it on its line
};

/// The encoding of the file before its conversion to UTF-8.
enum class Encoding : std::uint8_t { utf8, other };

/// The tokens of UTF-8 `text`; the last one is of kind `end`. Skips comments: from `//` to the end
/// of the line, and between `/*` and `*/`.
[[nodiscard]] std::vector<Token> tokenize(std::string_view text, Encoding encoding);

/// Whether a statement of the DBC format begins with this word.
[[nodiscard]] bool is_dbc_keyword(std::string_view word);

/// A token as error messages show it: 'word', a shortened "text", end of file.
[[nodiscard]] std::string show(const Token& token);

/// "file:line: text"
[[nodiscard]] std::string at_line(const std::string& file_name, std::uint32_t line,
                                  std::string_view text);

}  // namespace odomd::can
