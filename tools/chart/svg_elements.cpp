#include "tools/chart/svg_elements.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cstddef>
#include <string_view>

#include "tools/cli/text.hpp"

namespace odomd::tools::svg {
namespace {

// Bytes of the character at the start of UTF-8 text (Unicode 15, table 3-7); 0 if it is invalid.
std::size_t letter_length(std::string_view text) {
  const auto byte = [text](std::size_t i) {
    return i < text.size() ? static_cast<unsigned char>(text[i]) : 0U;
  };
  const unsigned first = byte(0);
  if (first < 0x80) return 1;
  const std::size_t length = first < 0xC2   ? 0
                             : first < 0xE0 ? 2
                             : first < 0xF0 ? 3
                             : first < 0xF5 ? 4
                                            : 0;
  // Rejects overlong forms, surrogates, and code points beyond U+10FFFF.
  const unsigned second = byte(1);
  if (first == 0xE0 && second < 0xA0) return 0;
  if (first == 0xED && second >= 0xA0) return 0;
  if (first == 0xF0 && second < 0x90) return 0;
  if (first == 0xF4 && second >= 0x90) return 0;
  for (std::size_t i = 1; i < length; ++i)
    if ((byte(i) & 0xC0U) != 0x80U) return 0;
  return length;
}

}  // namespace

std::string px(double value) {
  return fixed(value, 1);
}

std::string escaped(const std::string& text) {
  std::string out;
  std::string_view rest = text;
  while (!rest.empty()) {
    const std::size_t length = letter_length(rest);
    const std::string_view letter = rest.substr(0, std::max<std::size_t>(length, 1));
    rest.remove_prefix(letter.size());
    const char c = letter.front();
    if (length == 0) {
      out += "\uFFFD";
    } else if (c == '&') {
      out += "&amp;";
    } else if (c == '<') {
      out += "&lt;";
    } else if (c == '>') {
      out += "&gt;";
    } else if (c == '"') {
      out += "&quot;";
    } else if (static_cast<unsigned char>(c) < ' ') {
      out += ' ';
    } else {
      out += letter;
    }
  }
  return out;
}

std::string line(const std::string& data, const std::string& colour, double stroke) {
  return fmt::format(
      R"(<path d="{}" fill="none" stroke="{}" stroke-width="{}" stroke-linejoin="round" )"
      R"(stroke-linecap="round"/>)"
      "\n",
      data, colour, px(stroke));
}

std::string disc(double x, double y, double radius, const std::string& fill,
                 const std::string& stroke, double stroke_width) {
  return fmt::format(R"(<circle cx="{}" cy="{}" r="{}" fill="{}" stroke="{}" stroke-width="{}"/>)"
                     "\n",
                     px(x), px(y), px(radius), fill, stroke, px(stroke_width));
}

std::string words(double x, double y, double size, const std::string& attributes,
                  const std::string& content) {
  return fmt::format(R"(<text x="{}" y="{}" font-size="{}" {}>{}</text>)"
                     "\n",
                     px(x), px(y), px(size), attributes, content);
}

std::string clipped(double x, double y, double wide, double high, const std::string& content) {
  return fmt::format(R"(<svg x="{0}" y="{1}" width="{2}" height="{3}" viewBox="{0} {1} {2} {3}">)"
                     "\n{4}</svg>\n",
                     px(x), px(y), px(wide), px(high), content);
}

}  // namespace odomd::tools::svg
