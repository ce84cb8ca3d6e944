// The DBC lexer.
#include "can_protocol/dbc/lexer.hpp"

#include <algorithm>
#include <array>
#include <string>

#include "base/printable.hpp"
#include "can_protocol/dbc/dbc.hpp"

namespace odomd::can {
namespace {

constexpr std::array<std::string_view, 34> keywords{
    "VERSION",       "NS_",         "BS_",
    "BU_",           "BO_",         "SG_",
    "CM_",           "VAL_",        "VAL_TABLE_",
    "BA_",           "BA_DEF_",     "BA_DEF_DEF_",
    "SIG_VALTYPE_",  "SG_MUL_VAL_", "NS_DESC_",
    "CAT_DEF_",      "CAT_",        "FILTER",
    "EV_",           "EV_DATA_",    "ENVVAR_DATA_",
    "SGTYPE_",       "SGTYPE_VAL_", "SIG_GROUP_",
    "SIG_TYPE_REF_", "BA_SGTYPE_",  "BA_DEF_SGTYPE_",
    "BA_DEF_REL_",   "BA_REL_",     "BA_DEF_DEF_REL_",
    "BO_TX_BU_",     "BU_SG_REL_",  "BU_EV_REL_",
    "BU_BO_REL_"};

bool is_blank(char c) {
  return c == ' ' || c == '\t' || c == '\r' || c == '\f' || c == '\v';
}

bool is_word(char c) {
  return (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || (c >= '0' && c <= '9') || c == '_' ||
         c == '+' || c == '-' || c == '.' || static_cast<unsigned char>(c) >= 0x80;
}

class Lexer {
 public:
  Lexer(std::string_view text, Encoding encoding) : text_(text), encoding_(encoding) {}

  std::vector<Token> run() {
    while (at_ < text_.size()) {
      const char c = text_[at_];
      if (c == '\n') {
        ++line_;
        ++at_;
        starts_line_ = true;
      } else if (is_blank(c)) {
        ++at_;
      } else if (c == '"') {
        quoted();
      } else if (text_.substr(at_, 2) == "//") {
        skip_line();
      } else if (text_.substr(at_, 2) == "/*") {
        block_comment();
      } else if (is_word(c)) {
        const std::size_t first = at_;
        while (at_ < text_.size() && is_word(text_[at_])) ++at_;
        add(TokenKind::word, std::string(text_.substr(first, at_ - first)), line_);
      } else if (c > ' ' && c < '\x7F') {
        ++at_;
        add(TokenKind::punctuation, std::string(1, c), line_);
      } else {
        add(TokenKind::broken,
            "expected text, found byte " + std::to_string(static_cast<unsigned char>(c)) +
                "; save the file as plain text (UTF-8 or Latin-1)",
            line_);
        skip_line();
      }
    }
    add(TokenKind::end, {}, line_);
    return std::move(tokens_);
  }

 private:
  void add(TokenKind kind, std::string text, std::uint32_t line) {
    tokens_.push_back({kind, std::move(text), line, starts_line_});
    starts_line_ = false;
  }

  void skip_line() { at_ = std::min(text_.find('\n', at_), text_.size()); }

  void block_comment() {
    const std::size_t end = text_.find("*/", at_ + 2);
    if (end == std::string_view::npos) {
      add(TokenKind::broken,
          "expected '*/' that ends the comment begun here, found end of file; "
          "end it",
          line_);
      return skip_line();
    }
    line_ += static_cast<std::uint32_t>(std::count(text_.begin() + static_cast<std::ptrdiff_t>(at_),
                                                   text_.begin() + static_cast<std::ptrdiff_t>(end),
                                                   '\n'));
    at_ = end + 2;
  }

  [[nodiscard]] bool is_quote(std::size_t at) const {
    return at < text_.size() && text_[at] == '"';
  }

  /// The next character that is neither a blank nor a line end.
  [[nodiscard]] std::size_t next_after(std::size_t at) const {
    while (at < text_.size() && (is_blank(text_[at]) || text_[at] == '\n')) ++at;
    return at;
  }

  /// Whether only the ';' of the statement is left on the line.
  [[nodiscard]] bool ends_statement(std::size_t at) const {
    const auto skip_blanks = [&] {
      while (at < text_.size() && is_blank(text_[at])) ++at;
    };
    skip_blanks();
    if (at >= text_.size() || text_[at] != ';') return false;
    ++at;
    skip_blanks();
    return at >= text_.size() || text_[at] == '\n';
  }

  /// Whether the context shows that the quote before `at` closes a text: a unit, a list item before
  /// another item, or a value's name before the next value.
  [[nodiscard]] bool is_closed_by_context(std::size_t at) const {
    at = next_after(at);
    if (at >= text_.size()) return true;
    if (!tokens_.empty() && tokens_.back().text == "]") return true;
    if (text_[at] == ',') return is_quote(next_after(at + 1));
    const std::size_t number = at;
    while (at < text_.size() &&
           (std::string_view{"+-.0123456789"}.find(text_[at]) != std::string_view::npos))
      ++at;
    return at > number && is_quote(next_after(at));
  }

  /// A backslash before a quote keeps the quote in the text, unless the text ends there: a text may
  /// end with the backslash of a path, and in double-byte character sets (Shift-JIS, GBK, Big5) the
  /// backslash may be half of a character.
  [[nodiscard]] bool is_escaped_quote() const {
    if (text_[at_] != '\\' || at_ + 1 >= text_.size() || text_[at_ + 1] != '"') return false;
    if (ends_statement(at_ + 2)) return false;
    const bool may_be_half =
        encoding_ == Encoding::other && static_cast<unsigned char>(text_[at_ - 1]) >= 0x80;
    return !may_be_half || !is_closed_by_context(at_ + 2);
  }

  /// Whether a line within the text begins another statement.
  [[nodiscard]] static bool holds_statement(std::string_view text) {
    for (std::size_t at = text.find('\n'); at != std::string_view::npos; at = text.find('\n', at)) {
      ++at;
      while (at < text.size() && is_blank(text[at])) ++at;
      const std::size_t first = at;
      while (at < text.size() && is_word(text[at])) ++at;
      if (is_dbc_keyword(text.substr(first, at - first))) return true;
    }
    return false;
  }

  void quoted() {
    const std::size_t first = at_;
    const std::uint32_t first_line = line_;
    std::string text;
    for (++at_; at_ < text_.size(); ++at_) {
      char c = text_[at_];
      if (is_escaped_quote()) {
        c = text_[++at_];
      } else if (c == '"') {
        break;
      }
      if (c == '\n') ++line_;
      if (c != '\r') text += c;
    }
    const bool closed = at_ < text_.size();
    const std::size_t next = next_after(at_ + 1);
    const bool ends_comment = closed && next < text_.size() && text_[next] == ';';
    if (line_ != first_line && !ends_comment && holds_statement(text_.substr(first, at_ - first))) {
      line_ = first_line;
      at_ = first;
      skip_line();
      return add(TokenKind::broken,
                 "expected '\"' that closes the text begun here, found another statement; close it",
                 first_line);
    }
    if (!closed)
      return add(TokenKind::cut,
                 "expected '\"' that closes the text begun here, found end of file; "
                 "close it, or get the complete file if it was truncated",
                 first_line);
    ++at_;
    add(TokenKind::text, std::move(text), first_line);
  }

  std::string_view text_;
  Encoding encoding_;
  std::vector<Token> tokens_;
  std::size_t at_ = 0;
  std::uint32_t line_ = 1;
  bool starts_line_ = true;
};

}  // namespace

bool is_dbc_keyword(std::string_view word) {
  return std::ranges::find(keywords, word) != keywords.end();
}

std::vector<Token> tokenize(std::string_view text, Encoding encoding) {
  return Lexer(text, encoding).run();
}

std::string show(const Token& token) {
  if (token.kind == TokenKind::end) return "end of file";
  const std::string text = escaped(shortened(token.text, 40));
  return token.kind == TokenKind::text ? '"' + text + '"' : '\'' + text + '\'';
}

std::string at_line(const std::string& file_name, std::uint32_t line, std::string_view text) {
  return file_name + ':' + std::to_string(line) + ": " + std::string(text);
}

}  // namespace odomd::can
