// Walks over the tokens of a DBC: takes the expected ones, or reports in one line what was found
// instead.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "can_protocol/dbc/dbc.hpp"
#include "can_protocol/dbc/lexer.hpp"

namespace odomd::can {

/// A key that no message has, for warnings that concern no message.
inline constexpr std::uint64_t no_message = ~std::uint64_t{0};

/// A mistake in a statement. Only that statement is left out, unless the file ends there.
class DbcMistake : public DbcError {
 public:
  DbcMistake(const std::string& file_name, std::uint32_t at_line, std::string what)
      : DbcError(odomd::can::at_line(file_name, at_line, what)),
        line(at_line),
        text(std::move(what)) {}

  std::uint32_t line;
  std::string text;  ///< without file and line
};

class DbcCursor {
 public:
  /// Splits the text into tokens. All functions below that take tokens may throw DbcMistake.
  DbcCursor(std::string_view text, std::string file_name);

  [[nodiscard]] const Token& peek(std::size_t ahead = 0) const;
  /// Whether the file ends here, or within the quoted text that begins here.
  [[nodiscard]] bool at_end() const {
    return peek().kind == TokenKind::end || peek().kind == TokenKind::cut;
  }
  [[nodiscard]] bool at_punctuation(char c) const;
  /// Whether a statement begins here: a keyword at a line's start, or anywhere if it ends with '_'.
  [[nodiscard]] bool at_statement() const;
  const Token& take();
  /// Takes the character if it comes next.
  bool take_if(char c);

  // `what` completes "expected ..."; `fix` says how to correct it.
  void take_punctuation(char c, std::string_view what, std::string_view fix);
  std::string take_word(std::string_view what, std::string_view fix);
  /// A word with at least one letter; warns of characters that are not valid in a DBC name.
  std::string take_name(std::string_view what, std::string_view fix);
  std::string take_text(std::string_view what, std::string_view fix);
  /// A text of one line. Several lines are joined, with a warning.
  std::string take_line(std::string_view what, std::string_view fix);
  /// A name in quotes. Empty, with a warning, if it is not a valid name.
  std::string take_long_name();
  std::uint64_t take_unsigned(std::string_view what, std::uint64_t largest, std::string_view fix);
  /// A finite decimal number; `.25` is accepted with a warning.
  double take_number(std::string_view what, std::string_view fix);

  /// Takes the ';' of the statement that began with `keyword`. When the next statement begins
  /// instead, warns and continues.
  void end_statement(std::string_view keyword);
  /// Skips the rest of the statement, up to its ';' or the next statement.
  void skip_to_end();
  /// Calls skip_to_end() and end_statement().
  void skip_statement(std::string_view keyword);
  /// Recovers from a mistake: skips to the next line that begins with a keyword. Throws nothing.
  void skip_to_statement();

  /// At the end of the file: a last line with neither line end nor ';' is rejected if it looks
  /// truncated, otherwise warned about.
  void check_ending();

  [[noreturn]] void fail(const Token& found, std::string_view what, std::string_view fix) const;
  [[noreturn]] void fail_at(std::uint32_t line, const std::string& text) const;
  void warn(std::uint32_t line, std::string text);
  /// Warns that something cannot be used. After 20 such warnings, further ones are only counted.
  void warn_left_out(std::uint32_t line, std::string text);
  /// The message that warnings concern from now on (frame_key, or no_message); empty: the file.
  void concern(std::optional<std::uint64_t> message) { message_ = message; }

  [[nodiscard]] const std::string& file_name() const { return file_name_; }
  /// Sorted by line.
  [[nodiscard]] std::vector<Warning> take_warnings();

 private:
  std::string file_name_;
  std::vector<Token> tokens_;
  std::size_t at_ = 0;
  std::vector<Warning> warnings_;
  std::optional<std::uint64_t> message_;
  std::size_t left_out_ = 0;
};

/// The value of a word that is a number in [0, 2^64); otherwise empty.
[[nodiscard]] std::optional<std::uint64_t> unsigned_of(std::string_view word);

}  // namespace odomd::can
