#include "tools/config_patch/toml_lines.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cctype>
#include <optional>

namespace odomd::tools {
namespace {

constexpr std::string_view byte_order_mark = "\xef\xbb\xbf";

/// The offset after the quoted text that starts at `at`: "...", '...', """...""" or '''...'''.
std::size_t past_text(std::string_view text, std::size_t at) {
  const char quote = text[at];
  const bool escapes = quote == '"';
  const std::string three(3, quote);
  const bool several_lines = text.substr(at, 3) == three;
  at += several_lines ? 3 : 1;
  while (at < text.size()) {
    if (escapes && text[at] == '\\') {
      at += 2;
    } else if (several_lines ? text.substr(at, 3) == three : text[at] == quote) {
      at += several_lines ? 3 : 1;
      // Up to two quotes may precede the closing three.
      while (several_lines && at < text.size() && text[at] == quote) ++at;
      return at;
    } else {
      ++at;
    }
  }
  return text.size();
}

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

/// The line with the comment for an offset.
TomlLine line_with_comment_of(std::string_view text, std::size_t offset) {
  const std::vector<TomlLine> lines = toml_lines(text);
  std::size_t index = toml_line_of(lines, offset);
  while (lines[index].ends == TomlLine::Ends::inside_a_text) ++index;
  return lines[index];
}

struct Span {
  std::size_t begin = 0;
  std::size_t end = 0;
};

/// The range of odom's note with that label in a comment, including its brackets.
std::optional<Span> note_in(const std::string& comment, const std::string& label) {
  std::string opening = as_note(label, "odom ");
  opening.pop_back();
  const std::size_t begin = comment.find(opening);
  const std::size_t closing = comment.find(')', std::min(begin, comment.size()));
  if (begin == std::string::npos || closing == std::string::npos) return std::nullopt;
  return Span{begin, closing + 1};
}

}  // namespace

std::vector<TomlLine> toml_lines(std::string_view text) {
  std::vector<TomlLine> lines(1);
  std::size_t at = text.starts_with(byte_order_mark) ? byte_order_mark.size() : 0;
  lines.back().begin = at;
  const auto end_line = [&](std::size_t line_break, TomlLine::Ends ends) {
    TomlLine& line = lines.back();
    line.end = line_break;
    if (line.end > line.begin && text[line.end - 1] == '\r') --line.end;
    line.ends = ends;
    lines.push_back({.begin = line_break + 1});
  };
  while (at < text.size()) {
    const char c = text[at];
    if (c == '"' || c == '\'') {
      const std::size_t past = std::min(past_text(text, at), text.size());
      for (std::size_t i = at; i < past; ++i)
        if (text[i] == '\n') end_line(i, TomlLine::Ends::inside_a_text);
      at = past;
    } else if (c == '#') {
      lines.back().comment = at;
      at = std::min(text.find('\n', at), text.size());
    } else {
      if (c == '\n') end_line(at, TomlLine::Ends::plainly);
      ++at;
    }
  }
  lines.back().end = text.size();
  return lines;
}

std::size_t toml_offset(std::string_view text, const std::vector<TomlLine>& lines, std::size_t line,
                        std::size_t column) {
  std::size_t at = lines.at(line - 1).begin;
  for (; column > 1 && at < text.size(); --column) {
    ++at;
    while (at < text.size() && (static_cast<unsigned char>(text[at]) & 0xC0U) == 0x80U) ++at;
  }
  return at;
}

std::size_t toml_line_of(const std::vector<TomlLine>& lines, std::size_t offset) {
  const auto after = std::ranges::upper_bound(lines, offset, {}, &TomlLine::begin);
  return after == lines.begin() ? 0 : static_cast<std::size_t>(after - lines.begin()) - 1;
}

void set_toml_note(std::string& text, std::size_t offset, const std::string& label,
                   const std::string& note) {
  const TomlLine line = line_with_comment_of(text, offset);
  const std::string added = note.empty() ? "" : as_note(label, note);
  if (!line.has_comment()) {
    if (added.empty()) return;
    const std::string kept = trimmed(text.substr(line.begin, line.end - line.begin));
    text.replace(line.begin, line.end - line.begin, kept + "  # " + added);
    return;
  }
  std::string comment = trimmed(text.substr(line.comment, line.end - line.comment));
  if (const auto earlier = note_in(comment, label)) {
    comment.replace(earlier->begin, earlier->end - earlier->begin, added);
    if (added.empty()) comment = trimmed(comment);
  } else if (!added.empty()) {
    comment += " " + added;
  }
  text.replace(line.comment, line.end - line.comment, comment == "#" ? "" : comment);
}

std::string toml_note(const std::string& text, std::size_t offset, const std::string& label) {
  const TomlLine line = line_with_comment_of(text, offset);
  if (!line.has_comment()) return "";
  const std::string comment = text.substr(line.comment, line.end - line.comment);
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
