// The DBC lexer.
#include "can_protocol/dbc/lexer.hpp"

#include <algorithm>
#include <string>

#include "base/printable.hpp"
#include "can_protocol/dbc/dbc.hpp"

namespace odomd::can {
namespace {

bool is_blank(char c) {
  return c == ' ' || c == '\t' || c == '\r' || c == '\f' || c == '\v';
}

bool is_word(char c) {
  return (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || (c >= '0' && c <= '9') || c == '_' ||
         c == '+' || c == '-' || c == '.' || static_cast<unsigned char>(c) >= 0x80;
}

class Lexer {
 public:
  explicit Lexer(std::string_view text) : text_(text) {}

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
        at_ = std::min(text_.find('\n', at_), text_.size());
      } else if (is_word(c)) {
        const std::size_t first = at_;
        while (at_ < text_.size() && is_word(text_[at_])) ++at_;
        add(TokenKind::word, std::string(text_.substr(first, at_ - first)), line_);
      } else if (c > ' ' && c < '\x7F') {
        ++at_;
        add(TokenKind::punctuation, std::string(1, c), line_);
      } else {
        give_up(line_, "expected text, found byte " +
                           std::to_string(static_cast<unsigned char>(c)) +
                           "; save the file as plain text (UTF-8 or Latin-1)");
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

  void give_up(std::uint32_t line, std::string why) {
    add(TokenKind::broken, std::move(why), line);
    at_ = text_.size();
  }

  /// A backslash before a quote keeps the quote in the text, unless the statement ends there: some
  /// texts end in the backslash of a path.
  [[nodiscard]] bool is_escaped_quote() const {
    if (text_[at_] != '\\' || at_ + 1 >= text_.size() || text_[at_ + 1] != '"') return false;
    std::size_t next = at_ + 2;
    while (next < text_.size() && is_blank(text_[next])) ++next;
    if (next >= text_.size() || text_[next] != ';') return true;
    do ++next;
    while (next < text_.size() && is_blank(text_[next]));
    return next < text_.size() && text_[next] != '\n';
  }

  void quoted() {
    const std::uint32_t first_line = line_;
    std::string text;
    for (++at_; at_ < text_.size(); ++at_) {
      char c = text_[at_];
      if (is_escaped_quote()) {
        c = text_[++at_];
      } else if (c == '"') {
        ++at_;
        add(TokenKind::text, std::move(text), first_line);
        return;
      }
      if (c == '\n') ++line_;
      if (c != '\r') text += c;
    }
    give_up(first_line,
            "expected '\"' that closes the text begun here, found end of file; "
            "close it, or get the complete file if it was truncated");
  }

  std::string_view text_;
  std::vector<Token> tokens_;
  std::size_t at_ = 0;
  std::uint32_t line_ = 1;
  bool starts_line_ = true;
};

}  // namespace

std::vector<Token> tokenize(std::string_view text) {
  return Lexer(text).run();
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
