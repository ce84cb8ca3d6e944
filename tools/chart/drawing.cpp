#include "tools/chart/drawing.hpp"

#include <fmt/format.h>

#include "tools/chart/style.hpp"
#include "tools/chart/svg.hpp"

namespace odomd::tools::chart {

Drawing heading(const std::string& text) {
  return {text,
          svg::words(border, border + 40.0, 40.0,
                     fmt::format(R"(font-weight="bold" fill="{}")", ink), svg::escaped(text)),
          border + 48.0};
}

std::string as_svg(std::span<const Drawing> drawings) {
  std::string inside;
  std::string name;
  double height = 0.0;
  for (const Drawing& drawing : drawings) {
    name += (name.empty() ? "" : "; ") + drawing.name;
    inside += height == 0.0 ? drawing.svg
                            : fmt::format("<g transform=\"translate(0 {})\">\n{}</g>\n",
                                          svg::px(height), drawing.svg);
    height += drawing.height;
  }
  return fmt::format(
      R"svg(<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 {0} {1}" width="{0}" height="{1}" )svg"
      R"svg(role="img" aria-label="{2}" font-family="'DejaVu Sans', Verdana, Arial, sans-serif">
<rect width="100%" height="100%" fill="#FFFFFF"/>
{3}</svg>
)svg",
      svg::px(canvas), svg::px(height), svg::escaped(name), inside);
}

}  // namespace odomd::tools::chart
