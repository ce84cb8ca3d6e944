#include "tools/chart/axis.hpp"

#include <array>
#include <cmath>
#include <span>

#include <fmt/format.h>

#include "tools/chart/picture.hpp"
#include "tools/cli/text.hpp"

namespace odomd::tools::chart {
namespace {

using svg::px;

// Ticks at the multiples of a step within the range.
std::vector<Tick> multiples(const Range& range, double step) {
  const int decimals = decimals_for(step);
  std::vector<Tick> result;
  const double slack = 1e-9 * range.width();
  const double first = std::ceil((range.low - slack) / step);
  const auto steps = static_cast<int>(std::floor((range.high + slack) / step) - first);
  for (int i = 0; i <= steps; ++i) {
    const double value = (first + i) * step;
    result.push_back({value, number(value, decimals)});
  }
  return result;
}

// Ticks of a logarithmic axis: as fine as possible with at most `count` of them.
std::vector<Tick> decades(const Range& range, double count) {
  static constexpr std::array fine{1.0, 2.0, 5.0};
  const int first = static_cast<int>(std::floor(std::log10(range.low)));
  const int last = static_cast<int>(std::ceil(std::log10(range.high)));
  std::vector<Tick> result;
  const auto take = [&](std::span<const double> factors, int every) {
    result.clear();
    for (int power = first; power <= last; power += every) {
      for (const double factor : factors) {
        const double value = factor * std::pow(10.0, power);
        if (value >= range.low * (1.0 - 1e-9) && value <= range.high * (1.0 + 1e-9)) {
          result.push_back({value, fmt::format("{:g}", value)});
        }
      }
    }
    return static_cast<double>(result.size()) <= count;
  };
  if (take(fine, 1)) {
    constexpr std::size_t least = 3;  // with fewer the scale cannot be read
    if (result.size() >= least) return result;
    // Within a decade, use even steps; labels have the least room at the upper end.
    const double closest = range.high * (1.0 - std::pow(range.low / range.high, 1.0 / count));
    auto even = multiples(range, round_step(closest, 1.0));
    return even.size() > result.size() ? even : result;
  }
  for (int every = 1; !take(std::span(fine).first(1), every); ++every) continue;
  return result;
}

constexpr double mark_width = 52.0;
constexpr double gap = 34.0;
constexpr double row_height = 42.0;

}  // namespace

double Scale::operator()(double value) const {
  constexpr double farthest = 50.0;  // axis lengths: limits far points to what renderers accept
  double share = 0.0;
  if (scaling == Scaling::logarithmic) {
    share = std::log(std::max(value, 1e-300) / range.low) / std::log(range.high / range.low);
  } else {
    share = (value - range.low) / range.width();
  }
  return from + std::clamp(share, -farthest, farthest) * (to - from);
}

std::vector<Tick> ticks(const Range& range, Scaling scaling, double count) {
  if (scaling == Scaling::logarithmic) return decades(range, count);
  return multiples(range, round_step(range.width(), count));
}

double round_step(double length, double count) {
  const double raw = length / count;
  const double power = std::pow(10.0, std::floor(std::log10(raw)));
  for (const double factor : {1.0, 2.0, 5.0}) {
    if (raw <= factor * power) return factor * power;
  }
  return 10.0 * power;
}

Range with_room(Range range, Scaling scaling) {
  constexpr double room = 0.05;
  if (scaling == Scaling::logarithmic) {
    range.low = std::max(range.low, 1e-12);
    range.high = std::max(range.high, range.low);
    const double factor = std::max(std::pow(range.high / range.low, room), 1.1);
    return {range.low / factor, range.high * factor};
  }
  const double least = std::max(1e-9, 1e-9 * std::max(std::abs(range.low), std::abs(range.high)));
  const double margin = range.width() > least ? room * range.width() : std::max(0.5, least);
  return {range.low - margin, range.high + margin};
}

int decimals_for(double step) {
  return std::max(0, static_cast<int>(std::ceil(-std::log10(step) - 1e-9)));
}

std::string number(double value, int decimals) {
  std::string text = fixed(value, decimals);
  if (text.starts_with('-')) text.replace(0, 1, "\u2212");
  return text;
}

std::string grid(const std::vector<Tick>& x_ticks, const std::vector<Tick>& y_ticks, const Scale& x,
                 const Scale& y) {
  std::string lines;
  std::string labels;
  for (const Tick& tick : x_ticks) {
    const double at = x(tick.value);
    lines += fmt::format("M{} {}V{}", px(at), px(y.to), px(y.from));
    labels +=
        svg::words(at, y.from + tick_size + 8.0, tick_size, R"(text-anchor="middle")", tick.label);
  }
  for (const Tick& tick : y_ticks) {
    const double at = y(tick.value);
    lines += fmt::format("M{} {}H{}", px(x.from), px(at), px(x.to));
    labels += svg::words(x.from - 12.0, at + 0.35 * tick_size, tick_size, R"(text-anchor="end")",
                         tick.label);
  }
  return svg::line(lines, grid_colour, 1.5) +
         fmt::format("<g fill=\"{}\">\n{}</g>\n", faint_ink, labels);
}

std::string framed(const Scale& x, const Scale& y, const std::string& content) {
  const double wide = x.to - x.from, high = y.from - y.to;
  return fmt::format(
      R"(<svg x="{0}" y="{1}" width="{2}" height="{3}" viewBox="{0} {1} {2} {3}">)"
      "\n{4}</svg>\n"
      R"(<rect x="{0}" y="{1}" width="{2}" height="{3}" fill="none" stroke="{5}" stroke-width="2"/>)"
      "\n",
      px(x.from), px(y.to), px(wide), px(high), content, frame_colour);
}

std::string title_at(const std::string& title, double& top) {
  if (title.empty()) return {};
  const double below = top + title_size;
  top = below + 18.0;
  return svg::words(border, below, title_size, fmt::format(R"(font-weight="bold" fill="{}")", ink),
                    svg::escaped(title));
}

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
        "<g transform=\"translate({} {})\">\n{}{}</g>\n", px(x), px(y), entry.mark,
        svg::words(mark_width, 10.0, text_size, fmt::format(R"(fill="{}")", ink), content));
    result.bottom = y + 0.5 * row_height;
    x += needed + gap;
  }
  return result;
}

}  // namespace odomd::tools::chart
