#include "base/printable.hpp"

#include <algorithm>
#include <array>

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
namespace {

void append_utf8(std::string& out, std::uint32_t code_point) {
  if (code_point < 0x80) {
    out += static_cast<char>(code_point);
  } else if (code_point < 0x800) {
    out += static_cast<char>(0xC0U | code_point >> 6U);
    out += static_cast<char>(0x80U | (code_point & 0x3FU));
  } else {
    out += static_cast<char>(0xE0U | code_point >> 12U);
    out += static_cast<char>(0x80U | (code_point >> 6U & 0x3FU));
    out += static_cast<char>(0x80U | (code_point & 0x3FU));
  }
}

// Windows-1252 differs from Latin-1 in 0x80 to 0x9F only; undefined bytes become U+FFFD.
constexpr std::array<std::uint16_t, 32> windows_1252{
    0x20AC, 0xFFFD, 0x201A, 0x0192, 0x201E, 0x2026, 0x2020, 0x2021, 0x02C6, 0x2030, 0x0160,
    0x2039, 0x0152, 0xFFFD, 0x017D, 0xFFFD, 0xFFFD, 0x2018, 0x2019, 0x201C, 0x201D, 0x2022,
    0x2013, 0x2014, 0x02DC, 0x2122, 0x0161, 0x203A, 0x0153, 0xFFFD, 0x017E, 0x0178};

}  // namespace

bool is_continuation(char byte) {
  return (static_cast<unsigned char>(byte) & 0xC0U) == 0x80U;
}

Character character_at(std::string_view text, std::size_t at) {
  const auto lead = static_cast<unsigned char>(text[at]);
  if (lead < 0x80) return {lead, 1};
  const std::size_t length = lead >= 0xF0 ? 4 : lead >= 0xE0 ? 3 : 2;
  if (lead < 0xC2 || lead > 0xF4 || at + length > text.size()) return {};
  std::uint32_t code = lead & (0x7FU >> length);
  for (std::size_t i = 1; i < length; ++i) {
    if (!is_continuation(text[at + i])) return {};
    code = code << 6U | (static_cast<unsigned char>(text[at + i]) & 0x3FU);
  }
  constexpr std::array<std::uint32_t, 5> least{0, 0, 0x80, 0x800, 0x10000};
  const bool surrogate = code >= 0xD800 && code <= 0xDFFF;
  if (code < least[length] || code > 0x10FFFF || surrogate) return {};
  return {code, length};
}

bool is_utf8(std::string_view text) {
  Character character{.length = 1};
  for (; !text.empty() && character.length > 0; text.remove_prefix(character.length))
    character = character_at(text, 0);
  return text.empty();
}

std::string to_utf8(std::string_view text) {
  if (text.starts_with("\xEF\xBB\xBF")) text.remove_prefix(3);
  if (is_utf8(text)) return std::string(text);
  std::string out;
  out.reserve(text.size() + text.size() / 8);
  for (const char c : text) {
    const auto byte = static_cast<unsigned char>(c);
    append_utf8(out, byte >= 0x80 && byte < 0xA0 ? windows_1252[byte - 0x80U] : byte);
  }
  return out;
}

}  // namespace odomd
