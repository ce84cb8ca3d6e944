// Walks over the tokens of a DBC: takes what is expected, or says in one line what is not.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "can_protocol/dbc/dbc.hpp"
#include "can_protocol/dbc/lexer.hpp"

namespace odomd::can {

class DbcCursor {
 public:
  /// Tokenizes. Throws DbcError as every function here that takes something.
  DbcCursor(std::string_view text, std::string file_name);

  [[nodiscard]] const Token& peek(std::size_t ahead = 0) const;
  [[nodiscard]] bool at_end() const { return peek().kind == TokenKind::end; }
  [[nodiscard]] bool at_punctuation(char c) const;
  /// Whether a statement begins here, whatever stands before: names may look like keywords.
  [[nodiscard]] bool at_statement() const;
  const Token& take();
  /// Takes the character if it comes next.
  bool take_if(char c);

  // `what` completes "expected ..."; `mend` says how to put it right.
  void take_punctuation(char c, std::string_view what, std::string_view mend);
  std::string take_word(std::string_view what, std::string_view mend);
  /// A word with at least one letter; warns of characters that no DBC name has.
  std::string take_name(std::string_view what, std::string_view mend);
  std::string take_text(std::string_view what, std::string_view mend);
  std::uint64_t take_unsigned(std::string_view what, std::uint64_t largest, std::string_view mend);
  /// A finite decimal number; `.25` is taken with a warning.
  double take_number(std::string_view what, std::string_view mend);

  /// The ';' of the statement that began with `keyword`. Where the next statement begins instead,
  /// warns and goes on.
  void end_statement(std::string_view keyword);
  /// Passes over the rest of the statement, up to its ';' or the next statement.
  void skip_to_end();
  /// The same, and then end_statement.
  void skip_statement(std::string_view keyword);

  /// At the end of the file: refuses a last line without its end that looks cut off, and warns of
  /// one that could hide a cut.
  void check_ending();

  [[noreturn]] void fail(const Token& found, std::string_view what, std::string_view mend) const;
  [[noreturn]] void fail_at(std::uint32_t line, const std::string& text) const;
  void warn(std::uint32_t line, std::string text);

  [[nodiscard]] const std::string& file_name() const { return file_name_; }
  [[nodiscard]] std::vector<Warning>& warnings() { return warnings_; }

 private:
  std::string file_name_;
  std::vector<Token> tokens_;
  std::size_t at_ = 0;
  bool ends_in_newline_ = false;
  std::vector<Warning> warnings_;
};

/// Whether a statement of the DBC format begins with this word.
[[nodiscard]] bool is_dbc_keyword(std::string_view word);

/// The value of a whole word as a number in [0, 2^64), or nothing.
[[nodiscard]] std::optional<std::uint64_t> unsigned_of(std::string_view word);

}  // namespace odomd::can
