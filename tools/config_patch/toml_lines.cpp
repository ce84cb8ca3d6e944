#include "tools/config_patch/toml_lines.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cctype>
#include <optional>

namespace odomd::tools {
namespace {

/// The note must not contain its end mark, nor characters that are not allowed in a comment.
std::string as_note(const std::string& label, const std::string& note) {
  std::string inner = label.empty() ? note : label + ": " + note;
  for (char& c : inner) {
    if (c == '(') c = '[';
    if (c == ')') c = ']';
    if (std::iscntrl(static_cast<unsigned char>(c)) != 0) c = ' ';
  }
  return "(" + inner + ")";
}

std::string trimmed(std::string text) {
  while (!text.empty() && (text.back() == ' ' || text.back() == '\t')) text.pop_back();
  return text;
}

/// The range of odom's note with that label in a comment, including its brackets.
std::optional<TomlLine> note_in(const std::string& comment, const std::string& label) {
  std::string opening = as_note(label, "odom ");
  opening.pop_back();
  const std::size_t begin = comment.find(opening);
  const std::size_t closing = comment.find(')', std::min(begin, comment.size()));
  if (begin == std::string::npos || closing == std::string::npos) return std::nullopt;
  return TomlLine{begin, closing + 1};
}

}  // namespace

TomlLine toml_line(std::string_view text, std::size_t offset) {
  const std::size_t before = offset == 0 ? std::string_view::npos : text.rfind('\n', offset - 1);
  TomlLine line{before == std::string_view::npos ? 0 : before + 1,
                std::min(text.find('\n', offset), text.size())};
  if (line.end > line.begin && text[line.end - 1] == '\r') --line.end;
  return line;
}

std::size_t toml_comment(std::string_view text, std::size_t offset) {
  const TomlLine line = toml_line(text, offset);
  char quote = '\0';
  for (std::size_t at = line.begin; at < line.end; ++at) {
    const char c = text[at];
    if (quote == '\0' && c == '#') return at;
    if (quote == '"' && c == '\\')
      ++at;
    else if (quote == '\0' && (c == '"' || c == '\''))
      quote = c;
    else if (c == quote)
      quote = '\0';
  }
  return std::string_view::npos;
}

std::size_t toml_offset(std::string_view text, std::size_t line, std::size_t column) {
  std::size_t at = 0;
  for (; line > 1; --line) at = std::min(text.find('\n', at), text.size() - 1) + 1;
  for (; column > 1 && at < text.size(); --column) {
    ++at;
    while (at < text.size() && (static_cast<unsigned char>(text[at]) & 0xC0U) == 0x80U) ++at;
  }
  return at;
}

void set_toml_note(std::string& text, std::size_t offset, const std::string& label,
                   const std::string& note) {
  const TomlLine line = toml_line(text, offset);
  const std::size_t begin = toml_comment(text, offset);
  const std::string added = note.empty() ? "" : as_note(label, note);
  if (begin == std::string::npos) {
    if (added.empty()) return;
    const std::string kept = trimmed(text.substr(line.begin, line.end - line.begin));
    text.replace(line.begin, line.end - line.begin, kept + "  # " + added);
    return;
  }
  std::string comment = trimmed(text.substr(begin, line.end - begin));
  if (const auto earlier = note_in(comment, label)) {
    comment.replace(earlier->begin, earlier->end - earlier->begin, added);
    if (added.empty()) comment = trimmed(comment);
  } else if (!added.empty()) {
    comment += " " + added;
  }
  text.replace(begin, line.end - begin, comment == "#" ? "" : comment);
}

std::string toml_note(const std::string& text, std::size_t offset, const std::string& label) {
  const std::size_t at = toml_comment(text, offset);
  if (at == std::string::npos) return "";
  const std::string comment = text.substr(at, toml_line(text, offset).end - at);
  const auto note = note_in(comment, label);
  if (!note) return "";
  const std::size_t begin = comment.find("odom ", note->begin);
  return comment.substr(begin, note->end - 1 - begin);
}

std::string toml_key(std::string_view key) {
  const bool bare = !key.empty() && std::ranges::all_of(key, [](char c) {
    return std::isalnum(static_cast<unsigned char>(c)) != 0 || c == '_' || c == '-';
  });
  if (bare) return std::string(key);
  std::string text = "\"";
  for (const char c : key) {
    if (c == '"' || c == '\\') text += '\\';
    if (std::iscntrl(static_cast<unsigned char>(c)) != 0)
      text += fmt::format("\\u{:04x}", static_cast<unsigned>(static_cast<unsigned char>(c)));
    else
      text += c;
  }
  return text + '"';
}

}  // namespace odomd::tools
