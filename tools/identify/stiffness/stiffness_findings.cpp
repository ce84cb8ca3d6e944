#include "tools/identify/stiffness/cornering_stiffness.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <iterator>
#include <numbers>

#include "tools/chart/chart.hpp"
#include "tools/chart/picture.hpp"
#include "tools/cli/text.hpp"
#include "tools/diagnostics/kinds.hpp"
#include "tools/math/se2.hpp"

namespace odomd::tools {
namespace {

void add_stiffness(const std::string& axle, const AxleStiffness& found, Findings& findings) {
  Finding& finding = findings.add("cornering stiffness, " + axle,
                                  "vehicle.cornering_stiffness_" + axle, found.stiffness, "N/rad",
                                  fmt::format("slope at zero slip; within 10 % of it up to {:.1f}°",
                                              degrees * found.linear_range()));
  if (found.is_undetermined())
    finding.reject("too little slip for these markers; drive faster circles, and slow ones too");
}

/// One row per circle.
std::string circle_table(const FilmedCircles& films, const CorneringStiffness& found) {
  Table table{.header = {"film", "from [s]", "turns", "v [m/s]", "R [m]", "a_y [m/s2]",
                         "slip front [deg]", "rear [deg]", ""}};
  for (std::size_t k = 0; k < films.circles.size(); ++k) {
    const CircleRun& run = films.circles[k];
    table.rows.push_back({run.film, fixed(1e-9 * static_cast<double>(run.begin_ns), 1),
                          fixed(run.turned / (2.0 * std::numbers::pi), 2), fixed(run.speed, 2),
                          fixed(run.radius(), 2), fixed(run.lateral_accel, 2),
                          fixed(degrees * found.front.points[k].slip, 2),
                          fixed(degrees * found.rear.points[k].slip, 2),
                          !found.in_range[k] ? "beyond the linear range"
                          : found.is_used(k) ? ""
                                             : "off the curve"});
  }
  return table.text();
}

}  // namespace

Findings stiffness_findings(const FilmedCircles& films, const CorneringStiffness& found,
                            const diagnostics::Diagnostics& against) {
  Findings findings{.method = "stiffness",
                    .origin = fmt::format("{} filmed", counted(films.circles.size(), "circle")),
                    .warnings = films.warnings,
                    .table = circle_table(films, found) + '\n'};
  add_stiffness("front", found.front, findings);
  add_stiffness("rear", found.rear, findings);
  append(findings.warnings, against);
  if (!against.empty())
    for (Finding& finding : findings.values) finding.reject("contradicted: see the warning");
  const auto add = [&findings](const std::string& name, const Measured& measured,
                               const std::string& unit, const std::string& remark) {
    findings.add(name, "", measured, unit, remark).share =
        unit.empty() ? Share::meaningful : Share::meaningless;
  };
  add("steering angle when straight ahead", found.steering_offset, "rad",
      "for information; fit determines it from a lap");
  add("steering angle reported per angle of the wheels", found.steering_scale, "",
      "includes rolling resistance");
  for (const FilmAlignment& alignment : films.alignments)
    add("begin of the film after the log",
        {1e-9 * static_cast<double>(alignment.offset_ns), alignment.sigma_s}, "s", alignment.film);

  nlohmann::ordered_json& details = findings.details;
  details["scatter"] = found.scatter;
  details["centre_ahead"] = found.centre_ahead;
  details["free_steering_scale"] = found.free_steering_scale;
  details["linear_range"] = {{"front", found.front.linear_range()},
                             {"rear", found.rear.linear_range()}};
  details["grip"] = {{"front", found.front.grip}, {"rear", found.rear.grip}};
  for (std::size_t k = 0; k < films.circles.size(); ++k) {
    const CircleRun& run = films.circles[k];
    const AxlePoint& front = found.front.points[k];
    const AxlePoint& rear = found.rear.points[k];
    details["circles"].push_back({{"film", run.film},
                                  {"begin", 1e-9 * static_cast<double>(run.begin_ns)},
                                  {"end", 1e-9 * static_cast<double>(run.end_ns)},
                                  {"speed", run.speed},
                                  {"yaw_rate", run.yaw_rate},
                                  {"lateral_accel", run.lateral_accel},
                                  {"accelerometer", run.accelerometer.value},
                                  {"gyro", run.gyro.value},
                                  {"drift", run.drift.value},
                                  {"drift_sigma", run.drift.sigma},
                                  {"steering", run.steering.value},
                                  {"slip_front", front.slip},
                                  {"force_front", front.force},
                                  {"slip_rear", rear.slip},
                                  {"force_rear", rear.force},
                                  {"weight_front", front.weight},
                                  {"weight_rear", rear.weight}});
  }
  for (std::size_t axle = 0; axle < 2; ++axle) {
    const Finding& finding = findings.values[axle];
    if (finding.determined == Determined::yes &&
        !kind("stiffness_uncertain").limits.hold(2.0 * finding.sigma / finding.value))
      add_warning(findings.warnings, kind("stiffness_uncertain"), finding.name,
                  "2 sigma is {:.1f} %, and 5 % is possible",
                  200.0 * finding.sigma / finding.value);
  }
  return findings;
}

// A picture of the measured tyres: side force against slip angle of both axles, the circles as
// points, the slope at zero slip with its uncertainty, the fitted curve, and the linear range.
namespace {

// The circles of an axle. Right-hand circles are mirrored, so that both directions can be compared.
std::vector<chart::PlotSeries> dots(const AxleStiffness& axle) {
  constexpr auto discs = chart::Mark::discs;
  std::vector<chart::PlotSeries> groups{
      {.label = "circles to the left", .colour = chart::colour_of(1), .mark = discs},
      {.label = "circles to the right", .colour = chart::colour_of(2), .mark = discs},
      {.label = "left out", .colour = chart::faint_ink, .mark = discs}};
  for (const AxlePoint& point : axle.points) {
    const double sign = point.force < 0.0 ? -1.0 : 1.0;
    chart::PlotSeries& group = groups[!(point.weight > 0.5) ? 2 : point.force > 0.0 ? 0 : 1];
    group.points.push_back({sign * degrees * point.slip, sign * point.force});
  }
  std::erase_if(groups, [](const chart::PlotSeries& group) { return group.points.empty(); });
  for (chart::PlotSeries& group : groups) std::ranges::sort(group.points, {}, &chart::Point::x);
  return groups;
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
  chart::PlotSeries curve{.label = "fitted curve", .colour = chart::ink};
  for (int k = 0; k <= 100; ++k) {
    const double at = slip * k / 100.0;
    curve.points.push_back({degrees * at, axle.force(at)});
  }
  picture.series.push_back(std::move(curve));
  std::ranges::move(dots(axle), std::back_inserter(picture.series));
  return draw(picture);
}

}  // namespace

std::vector<chart::Drawing> draw_stiffness(const CorneringStiffness& found) {
  return {draw_axle(found.front, "Front axle"), draw_axle(found.rear, "Rear axle")};
}

}  // namespace odomd::tools
