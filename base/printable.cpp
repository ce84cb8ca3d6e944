#include "base/printable.hpp"

#include <algorithm>

#include "base/utf8.hpp"

namespace odomd {
namespace {

constexpr std::size_t longest_quoted = 60;
constexpr std::size_t longest_message = 1000;
constexpr std::size_t its_end = 300;

bool is_obeyed(std::uint32_t code) {
  const bool control = code < 0x20 || (code >= 0x7F && code < 0xA0);
  const bool turns = code == 0x061C || code == 0x200E || code == 0x200F ||
                     (code >= 0x2028 && code <= 0x202E) || (code >= 0x2066 && code <= 0x2069);
  return control || turns;
}

/// Appends \x9b or \u001b.
void append_code(std::string& out, char kind, unsigned digits, std::uint32_t value) {
  constexpr std::string_view hex = "0123456789abcdef";
  out += '\\';
  out += kind;
  while (digits-- > 0) out += hex[value >> (4 * digits) & 0xFU];
}

/// The start of the character that contains the byte at `at`.
std::size_t begin_of_character(std::string_view text, std::size_t at) {
  for (int i = 0; i < 3 && at > 0 && at < text.size() && is_continuation(text[at]); ++i) --at;
  return at;
}

}  // namespace

std::string escaped(std::string_view text, LineBreaks line_breaks) {
  std::string out;
  out.reserve(text.size());
  for (std::size_t at = 0; at < text.size();) {
    const Character character = character_at(text, at);
    const bool kept = line_breaks == LineBreaks::kept && (text[at] == '\n' || text[at] == '\t');
    if (character.length == 0) {
      append_code(out, 'x', 2, static_cast<unsigned char>(text[at]));
    } else if (!is_obeyed(character.code) || kept) {
      out.append(text, at, character.length);
    } else if (text[at] == '\n') {
      out += "\\n";
    } else if (text[at] == '\t') {
      out += "\\t";
    } else {
      append_code(out, 'u', 4, character.code);
    }
    at += std::max<std::size_t>(character.length, 1);
  }
  return out;
}

std::string shortened(std::string_view text, std::size_t longest) {
  if (text.size() <= longest) return std::string(text);
  return std::string(text.substr(0, begin_of_character(text, longest))) + "…";
}

std::string quoted(std::string_view text) {
  return '"' + escaped(shortened(text, longest_quoted)) + '"';
}

std::string one_line(std::string_view message) {
  if (message.size() <= longest_message) return escaped(message);
  const std::size_t end = begin_of_character(message, message.size() - its_end);
  return escaped(shortened(message, longest_message - its_end)) + escaped(message.substr(end));
}

}  // namespace odomd
