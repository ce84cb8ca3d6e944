// Takes tokens and reports errors.
#include "can_protocol/dbc/cursor.hpp"

#include <algorithm>
#include <cctype>
#include <charconv>
#include <cmath>
#include <span>
#include <utility>

#include "base/printable.hpp"

namespace odomd::can {
namespace {

/// How many left-out items get a warning of their own.
constexpr std::size_t listed_left_out = 20;

/// The limit of the format is 32; editors write up to 128.
constexpr std::size_t longest_name = 255;

bool is_letter(char c) {
  return (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || c == '_';
}
bool is_digit(char c) {
  return c >= '0' && c <= '9';
}

}  // namespace

std::optional<std::uint64_t> unsigned_of(std::string_view word) {
  std::uint64_t value = 0;
  const char* end = word.data() + word.size();
  const auto [stop, error] = std::from_chars(word.data(), end, value);
  if (word.empty() || error != std::errc{} || stop != end) return std::nullopt;
  return value;
}

DbcCursor::DbcCursor(std::string_view text, std::string file_name)
    : file_name_(std::move(file_name)),
      tokens_(tokenize(to_utf8(text), is_utf8(text) ? Encoding::utf8 : Encoding::other)) {}

const Token& DbcCursor::peek(std::size_t ahead) const {
  return tokens_[std::min(at_ + ahead, tokens_.size() - 1)];
}

bool DbcCursor::at_punctuation(char c) const {
  return peek().kind == TokenKind::punctuation && peek().text[0] == c;
}

bool DbcCursor::at_statement() const {
  const Token& token = peek();
  return token.kind == TokenKind::word && (token.starts_line || token.text.ends_with('_')) &&
         is_dbc_keyword(token.text);
}

const Token& DbcCursor::take() {
  const Token& token = peek();
  if (token.kind == TokenKind::broken || token.kind == TokenKind::cut)
    fail_at(token.line, token.text);
  if (token.kind != TokenKind::end) ++at_;
  return token;
}

bool DbcCursor::take_if(char c) {
  const bool there = at_punctuation(c);
  if (there) ++at_;
  return there;
}

void DbcCursor::take_punctuation(char c, std::string_view what, std::string_view fix) {
  if (!take_if(c)) fail(peek(), std::string{'\'', c, '\''}.append(" ").append(what), fix);
}

std::string DbcCursor::take_word(std::string_view what, std::string_view fix) {
  if (peek().kind != TokenKind::word) fail(peek(), what, fix);
  return take().text;
}

std::string DbcCursor::take_name(std::string_view what, std::string_view fix) {
  const Token& token = peek();
  if (token.kind != TokenKind::word ||
      std::none_of(token.text.begin(), token.text.end(), is_letter))
    fail(token, what, fix);
  if (token.text.size() > longest_name)  // warnings repeat the name
    fail_at(token.line, "expected a name of at most " + std::to_string(longest_name) +
                            " bytes, found " + std::to_string(token.text.size()) + ": " +
                            show(token) + "; shorten it");
  if (!is_letter(token.text[0]))
    warn(token.line, "the name " + show(token) + " does not start with a letter");
  else if (!std::all_of(token.text.begin(), token.text.end(),
                        [](char c) { return is_letter(c) || is_digit(c); }))
    warn(token.line, "the name " + show(token) + " has characters other than letters and digits");
  return take().text;
}

std::string DbcCursor::take_text(std::string_view what, std::string_view fix) {
  if (peek().kind != TokenKind::text) fail(peek(), what, fix);
  return take().text;
}

std::string DbcCursor::take_line(std::string_view what, std::string_view fix) {
  const Token token = peek();
  std::string text = take_text(what, fix);
  if (text.find('\n') == std::string::npos) return text;
  warn(token.line, "the text " + show(token) + " is on several lines; joined to one");
  std::ranges::replace(text, '\n', ' ');
  return text;
}

std::string DbcCursor::take_long_name() {
  const Token token = peek();
  std::string name = take_text("the long name in quotes", "write \"NAME\"");
  const bool printable = std::all_of(name.begin(), name.end(), [](char c) {
    return c != '\x7F' && (c > ' ' || static_cast<unsigned char>(c) >= 0x80);
  });
  if (printable && name.size() <= longest_name) return name;
  warn(token.line, "the long name " + show(token) + " has blanks or more than 255 bytes; ignored");
  return {};
}

std::uint64_t DbcCursor::take_unsigned(std::string_view what, std::uint64_t largest,
                                       std::string_view fix) {
  const Token& token = peek();
  const auto value = token.kind == TokenKind::word ? unsigned_of(token.text) : std::nullopt;
  if (!value || *value > largest) fail(token, what, fix);
  take();
  return *value;
}

double DbcCursor::take_number(std::string_view what, std::string_view fix) {
  const Token& token = peek();
  std::string_view digits = token.text;
  if (digits.starts_with('+')) digits.remove_prefix(1);
  double value = 0.0;
  const char* end = digits.data() + digits.size();
  const auto [stop, error] = std::from_chars(digits.data(), end, value);
  if (token.kind != TokenKind::word || digits.empty() || error != std::errc{} || stop != end ||
      !std::isfinite(value))
    fail(token, what, fix);
  if (digits.starts_with('-')) digits.remove_prefix(1);
  if (digits.starts_with('.'))
    warn(token.line, "the number " + show(token) + " has no digit before its point");
  take();
  return value;
}

void DbcCursor::end_statement(std::string_view keyword) {
  if (take_if(';')) return;
  if (peek().kind == TokenKind::broken || peek().kind == TokenKind::cut) take();
  const std::uint32_t line = tokens_[at_ == 0 ? 0 : at_ - 1].line;  // where the ';' is missing
  const std::string text =
      "expected ';' at the end of " + std::string(keyword) + ", found " + show(peek());
  if (!at_statement() && !(at_end() && peek().starts_line))
    fail_at(line, text + (at_end() ? "; the file seems to be truncated, get the complete file"
                                   : "; close the statement"));
  warn(line, text + "; treated as closed");
}

void DbcCursor::skip_to_end() {
  while (!at_end() && !at_punctuation(';') && !(at_statement() && peek().starts_line)) take();
}

void DbcCursor::skip_statement(std::string_view keyword) {
  skip_to_end();
  end_statement(keyword);
}

void DbcCursor::skip_to_statement() {
  while (!at_end() && !(at_statement() && peek().starts_line)) ++at_;
}

void DbcCursor::check_ending() {
  if (peek().kind == TokenKind::cut) take();
  if (peek().starts_line || at_ == 0 || tokens_[at_ - 1].text == ";" ||
      tokens_[at_ - 1].kind == TokenKind::broken)
    return;
  // The last word must be a receiver or a sender. A node's name that occurred before is probably
  // complete.
  const Token& last = tokens_[at_ - 1];
  const auto before = std::span(tokens_).first(at_ - 1);
  const bool is_name = last.kind == TokenKind::word && !last.text.empty() &&
                       std::isdigit(static_cast<unsigned char>(last.text.front())) == 0;
  if (!is_name || std::ranges::find(before, last.text, &Token::text) == before.end())
    fail_at(last.line, "expected a line end after " + show(last) +
                           ", found end of file; get the complete file if it was truncated, or add "
                           "the line end");
  warn(last.line, "the file does not end with a line end: it may be truncated");
}

void DbcCursor::fail(const Token& found, std::string_view what, std::string_view fix) const {
  if (found.kind == TokenKind::broken || found.kind == TokenKind::cut)
    fail_at(found.line, found.text);
  fail_at(found.line, std::string("expected ")
                          .append(what)
                          .append(", found ")
                          .append(show(found))
                          .append("; ")
                          .append(fix));
}

void DbcCursor::fail_at(std::uint32_t line, const std::string& text) const {
  throw DbcMistake(file_name_, line, text);
}

void DbcCursor::warn(std::uint32_t line, std::string text) {
  warnings_.push_back({line, std::move(text), message_});
}

void DbcCursor::warn_left_out(std::uint32_t line, std::string text) {
  if (++left_out_ <= listed_left_out) warn(line, std::move(text));
}

std::vector<Warning> DbcCursor::take_warnings() {
  std::ranges::stable_sort(warnings_, {}, &Warning::line);
  if (left_out_ > listed_left_out)
    warnings_.push_back({peek().line,
                         std::to_string(left_out_ - listed_left_out) +
                             " more messages, signals or statements cannot be used; left out",
                         no_message});
  return std::move(warnings_);
}

}  // namespace odomd::can
