#include "tools/chart/svg_elements.hpp"

#include <fmt/format.h>

#include <nlohmann/json.hpp>

#include "tools/cli/text.hpp"

namespace odomd::tools::svg {
std::string px(double value) {
  return fixed(value, 1);
}

std::string escaped(const std::string& text) {
  // Writing and reading JSON replaces bytes that are not UTF-8.
  std::string out;
  for (const char c : nlohmann::json::parse(json_text(text)).get<std::string>()) {
    switch (c) {
      case '&':
        out += "&amp;";
        break;
      case '<':
        out += "&lt;";
        break;
      case '>':
        out += "&gt;";
        break;
      case '"':
        out += "&quot;";
        break;
      default:
        out += static_cast<unsigned char>(c) < ' ' && c != '\n' ? ' ' : c;
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

}  // namespace odomd::tools::svg
