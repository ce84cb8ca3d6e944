#include "tools/chart/legend.hpp"

#include <fmt/format.h>

#include "tools/chart/style.hpp"
#include "tools/chart/svg.hpp"
#include "tools/cli/text.hpp"

namespace odomd::tools::chart {
namespace {

constexpr double mark_width = 52.0;
constexpr double gap = 34.0;
constexpr double row_height = 42.0;

}  // namespace

std::string line_mark(const std::string& colour, double stroke) {
  return svg::line("M2 0H40", colour, stroke);
}

std::string dot_mark(const std::string& colour) {
  return svg::disc(24.0, 0.0, 7.0, colour, "none", 0.0);
}

std::string area_mark(const std::string& colour) {
  return fmt::format(R"(<rect x="2" y="-11" width="38" height="22" fill="{}" fill-opacity="0.25"/>)"
                     "\n",
                     colour);
}

Legend legend(const std::vector<LegendEntry>& entries, double top) {
  Legend result{{}, top};
  double x = border;
  double y = top + 0.5 * row_height;
  for (const auto& entry : entries) {
    const std::size_t letters =
        width(entry.label) + (entry.note.empty() ? 0 : width(entry.note) + 1);
    const double needed = mark_width + letter_width * text_size * static_cast<double>(letters);
    if (x > border && x + needed > canvas - border) {
      x = border;
      y += row_height;
    }
    std::string content = svg::escaped(entry.label);
    if (!entry.note.empty()) {
      content += fmt::format(R"(<tspan fill="{}" dx="10">{}</tspan>)", faint_ink,
                             svg::escaped(entry.note));
    }
    result.svg += fmt::format(
        "<g transform=\"translate({} {})\">\n{}{}</g>\n", svg::px(x), svg::px(y), entry.mark,
        svg::words(mark_width, 10.0, text_size, fmt::format(R"(fill="{}")", ink), content));
    result.bottom = y + 0.5 * row_height;
    x += needed + gap;
  }
  return result;
}

}  // namespace odomd::tools::chart
