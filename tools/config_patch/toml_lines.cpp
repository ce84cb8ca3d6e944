#include "tools/config_patch/config_patch.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cctype>

namespace odomd::tools {
namespace {

/// The note in round brackets, with no round brackets and no control characters inside.
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

/// odom's note with that label in a comment, including its brackets; empty if there is none.
std::string_view note_in(std::string_view comment, const std::string& label) {
  std::string opening = as_note(label, "odom ");
  opening.pop_back();
  const std::size_t begin = std::min(comment.find(opening), comment.size());
  const std::size_t closing = comment.find(')', begin);
  if (closing == std::string_view::npos) return {};
  return comment.substr(begin, closing + 1 - begin);
}

}  // namespace

TomlLine toml_line(std::string_view text, std::size_t offset) {
  TomlLine line{.begin = offset == 0 ? 0 : text.rfind('\n', offset - 1) + 1,
                .end = std::min(text.find('\n', offset), text.size())};
  if (line.end > line.begin && text[line.end - 1] == '\r') --line.end;
  char quote = '\0';
  for (line.comment = line.begin; line.comment < line.end; ++line.comment) {
    const char c = text[line.comment];
    if (quote == '\0' && c == '#') break;
    if (quote == '"' && c == '\\')
      ++line.comment;
    else if (quote == '\0' && (c == '"' || c == '\''))
      quote = c;
    else if (c == quote)
      quote = '\0';
  }
  line.comment = std::min(line.comment, line.end);
  return line;
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
  const std::string added = note.empty() ? "" : as_note(label, note);
  std::string comment = trimmed(text.substr(line.comment, line.end - line.comment));
  if (comment.empty()) {
    if (added.empty()) return;
    const std::string kept = trimmed(text.substr(line.begin, line.end - line.begin));
    text.replace(line.begin, line.end - line.begin, kept + "  # " + added);
    return;
  }
  if (const std::string_view earlier = note_in(comment, label); !earlier.empty()) {
    comment.replace(static_cast<std::size_t>(earlier.data() - comment.data()), earlier.size(),
                    added);
    if (added.empty()) comment = trimmed(comment);
  } else if (!added.empty()) {
    comment += " " + added;
  }
  text.replace(line.comment, line.end - line.comment, comment == "#" ? "" : comment);
}

std::string toml_note(const std::string& text, std::size_t offset, const std::string& label) {
  const TomlLine line = toml_line(text, offset);
  const std::string comment = text.substr(line.comment, line.end - line.comment);
  const std::string_view note = note_in(comment, label);
  if (note.empty()) return "";
  const std::size_t begin = note.find("odom ");
  return std::string(note.substr(begin, note.size() - 1 - begin));
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
