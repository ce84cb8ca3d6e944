// The measured tyres as a picture: side force over slip angle of both axles, the circles as points,
// the slope at zero slip with its uncertainty, the fitted curve, and the linear range.
#include <algorithm>
#include <cmath>
#include <numbers>

#include "tools/chart/chart.hpp"
#include "tools/chart/drawing.hpp"
#include "tools/cli/text.hpp"
#include "tools/identify/stiffness/stiffness_findings.hpp"

namespace odomd::tools {
namespace {

constexpr double degrees = 180.0 / std::numbers::pi;

enum class Side : std::uint8_t { left, right, left_out };

Side side_of(const AxlePoint& point) {
  if (!(point.weight > 0.5)) return Side::left_out;
  return point.force > 0.0 ? Side::left : Side::right;
}

// Circles to the right are turned over, so that both sides can be compared.
chart::Series dots(const AxleStiffness& axle, Side side, std::string label, std::string colour) {
  chart::Series series{.label = std::move(label),
                       .note = {},
                       .colour = std::move(colour),
                       .points = {},
                       .mark = chart::Mark::discs};
  for (const AxlePoint& point : axle.points) {
    const double sign = point.force < 0.0 ? -1.0 : 1.0;
    if (side_of(point) == side)
      series.points.push_back({sign * degrees * point.slip, sign * point.force});
  }
  std::ranges::sort(series.points, {}, &chart::Point::x);
  return series;
}

chart::Drawing draw_axle(const AxleStiffness& axle, const std::string& name) {
  double slip = 0.0, force = 0.0;
  for (const AxlePoint& point : axle.points) {
    slip = std::max(slip, 1.15 * std::abs(point.slip));
    force = std::max(force, 1.15 * std::abs(point.force));
  }
  const Measured c = axle.stiffness;
  chart::Chart picture;
  picture.title = name;
  picture.x = {.label = "slip angle [°]", .range = chart::Range{0.0, degrees * slip}};
  picture.y = {.label = "side force [N]", .range = chart::Range{0.0, force}};

  const double linear = degrees * std::min(axle.linear_range(), slip);
  picture.bands.push_back({.label = "linear range: within 10 % of the slope",
                           .colour = chart::frame_colour,
                           .points = {{0.0, 0.0, force}, {linear, 0.0, force}}});
  const double least = std::max(c.value - 2.0 * c.sigma, 0.0), most = c.value + 2.0 * c.sigma;
  picture.bands.push_back(
      {.label = "2σ",
       .colour = chart::colour_of(0),
       .points = {{0.0, 0.0, 0.0}, {degrees * slip, least * slip, most * slip}}});
  picture.series.push_back({.label = "slope at zero slip",
                            .note = fixed(c.value, 2) + " N/rad ± " + fixed(2.0 * c.sigma, 2),
                            .colour = chart::colour_of(0),
                            .points = {{0.0, 0.0}, {degrees * slip, c.value * slip}}});
  chart::Series curve{.label = "fitted curve", .note = {}, .colour = chart::ink, .points = {}};
  for (int k = 0; k <= 100; ++k) {
    const double at = slip * k / 100.0;
    curve.points.push_back({degrees * at, axle.force(at)});
  }
  picture.series.push_back(std::move(curve));
  picture.series.push_back(dots(axle, Side::left, "circles to the left", chart::colour_of(1)));
  picture.series.push_back(dots(axle, Side::right, "circles to the right", chart::colour_of(2)));
  picture.series.push_back(dots(axle, Side::left_out, "left out", chart::faint_ink));
  std::erase_if(picture.series, [](const chart::Series& series) { return series.points.empty(); });
  return draw(picture);
}

}  // namespace

std::vector<chart::Drawing> draw_stiffness(const CorneringStiffness& found) {
  return {draw_axle(found.front, "Front axle"), draw_axle(found.rear, "Rear axle")};
}

}  // namespace odomd::tools
