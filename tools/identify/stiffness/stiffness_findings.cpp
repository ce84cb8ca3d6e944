#include "tools/diagnostics/kinds.hpp"
#include "tools/identify/stiffness/stiffness.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numbers>

#include "tools/chart/chart.hpp"
#include "tools/chart/drawing.hpp"
#include "tools/cli/text.hpp"
#include "tools/identify/common/refuse.hpp"

namespace odomd::tools {
namespace {

using tools::kind;

constexpr double degrees = 180.0 / std::numbers::pi;

// Beyond these, circles and what was given cannot both be right.
constexpr double farthest_centre = 0.03;    // of the wheelbase
constexpr double farthest_steering = 1.33;  // times

// Known to no better than a quarter: too little to be written anywhere.
bool is_undetermined(const AxleStiffness& axle) {
  return 4.0 * axle.stiffness.sigma > axle.stiffness.value;
}

Finding stiffness_finding(const std::string& axle, const AxleStiffness& found) {
  Finding finding{.name = "cornering stiffness, " + axle,
                  .key = "vehicle.cornering_stiffness_" + axle,
                  .value = found.stiffness.value,
                  .sigma = found.stiffness.sigma,
                  .unit = "N/rad"};
  if (is_undetermined(found)) {
    finding.determined = Determined::no;
    finding.remark = "too little slip for these markers; drive faster circles, and slow ones too";
  } else {
    finding.remark = fmt::format("slope at zero slip; within 10 % of it up to {:.1f}°",
                                 degrees * found.linear_range());
  }
  return finding;
}

}  // namespace

void require_slip(const CorneringStiffness& found) {
  if (!is_undetermined(found.front) || !is_undetermined(found.rear)) return;
  double slip = 0.0, sigma = 0.0;
  for (const AxlePoint& point : found.rear.points) {
    slip = std::max(slip, std::abs(point.force) / found.rear.stiffness.value);
    sigma = std::max(sigma, point.sigma);
  }
  refuse(
      "the circles are too slow or too noisy: the largest slip angle is about {:.2f}°, and the "
      "film resolves {:.2f}°; drive faster, or film sharper and closer, with the markers farther "
      "apart and measured more precisely",
      degrees * slip,
      degrees * std::max(sigma, slip * found.rear.stiffness.sigma / found.rear.stiffness.value));
}

diagnostics::Diagnostics contradictions(const FilmedCircles& films, const CorneringStiffness& found,
                                        const CircleCar& car) {
  diagnostics::Diagnostics lines;
  const Measured& ahead = found.centre_ahead;
  if (std::abs(ahead.value) >
      std::max(4.0 * std::hypot(ahead.sigma, car.sigma_marker), farthest_centre * car.wheelbase()))
    lines.push_back(diagnostics::found(
        kind("centre_contradicted"), {},
        fmt::format(
            "by the circles the centre of gravity lies {:.3f} m {} the place in --front and "
            "--rear",
            std::abs(ahead.value), ahead.value > 0.0 ? "ahead of" : "behind")));
  for (const Measured& scale : {found.steering_scale, found.free_steering_scale})
    if (lines.empty() && (scale.value > farthest_steering || scale.value < 1.0 / farthest_steering))
      lines.push_back(diagnostics::found(
          kind("steering_contradicted"), {},
          fmt::format("the log's steering is {:.2f} times the angle of the wheels by the circles",
                      scale.value)));
  const auto slope = accelerometer_slope(films.circles);
  if (slope && std::abs(slope->value - 1.0) > std::max(gross_scale_error, 3.0 * slope->sigma))
    lines.push_back(diagnostics::found(
        kind("film_acceleration_off"), {},
        fmt::format("the accelerometer reads {:.0f} % of the film's lateral acceleration, and one "
                    "of the two is wrong",
                    100.0 * slope->value)));
  const auto fitted = std::ranges::count(found.in_range, true);
  if (lines.empty() && 2 * found.used < static_cast<std::size_t>(fitted))
    lines.push_back(diagnostics::found(
        kind("circles_off_curve"), {},
        fmt::format("of {} fitted {} lie on the curve",
                    counted(static_cast<std::size_t>(fitted), "circle"), found.used)));
  return lines;
}

Findings stiffness_findings(const FilmedCircles& films, const CorneringStiffness& found,
                            const diagnostics::Diagnostics& against) {
  Findings findings{.method = "stiffness",
                    .origin = fmt::format("{} filmed", counted(films.circles.size(), "circle")),
                    .warnings = films.warnings};
  findings.values.push_back(stiffness_finding("front", found.front));
  findings.values.push_back(stiffness_finding("rear", found.rear));
  append(findings.warnings, against);
  if (!against.empty())
    for (Finding& finding : findings.values) {
      finding.determined = Determined::no;
      finding.remark = "contradicted: see the warning";
    }
  findings.values.push_back({.name = "steering angle when straight ahead",
                             .value = found.steering_offset.value,
                             .sigma = found.steering_offset.sigma,
                             .unit = "rad",
                             .remark = "for information; fit determines it from a lap",
                             .share = Share::meaningless});
  findings.values.push_back({.name = "steering angle reported per angle of the wheels",
                             .value = found.steering_scale.value,
                             .sigma = found.steering_scale.sigma,
                             .remark = "includes rolling resistance"});
  for (std::size_t k = 0; k < films.names.size(); ++k)
    findings.values.push_back({.name = "begin of the film after the log",
                               .value = 1e-9 * static_cast<double>(films.alignments[k].offset_ns),
                               .sigma = films.alignments[k].sigma_s,
                               .unit = "s",
                               .remark = films.names[k],
                               .share = Share::meaningless});
  for (const FilmAlignment& film : films.alignments)
    findings.details["films"].push_back({{"rate", film.rate}, {"rate_sigma", film.rate_sigma}});

  nlohmann::ordered_json& details = findings.details;
  details["scatter"] = found.scatter;
  details["centre_ahead"] = {{"value", found.centre_ahead.value},
                             {"sigma", found.centre_ahead.sigma}};
  details["free_steering_scale"] = {{"value", found.free_steering_scale.value},
                                    {"sigma", found.free_steering_scale.sigma}};
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
      findings.warnings.push_back(
          diagnostics::found(kind("stiffness_uncertain"), finding.name,
                             fmt::format("2 sigma is {:.1f} %, and 5 % is possible",
                                         200.0 * finding.sigma / finding.value)));
  }
  return findings;
}

std::string circle_table(const FilmedCircles& films, const CorneringStiffness& found) {
  Table table{.header = {"film", "from [s]", "turns", "v [m/s]", "R [m]", "a_y [m/s2]",
                         "slip front [deg]", "rear [deg]", ""}};
  for (std::size_t k = 0; k < films.circles.size(); ++k) {
    const CircleRun& run = films.circles[k];
    const bool kept = found.front.points[k].weight > 0.5 && found.rear.points[k].weight > 0.5;
    table.rows.push_back({run.film, fixed(1e-9 * static_cast<double>(run.begin_ns), 1),
                          fixed(run.turned / 6.283185307179586, 2), fixed(run.speed, 2),
                          fixed(run.radius(), 2), fixed(run.lateral_accel, 2),
                          fixed(degrees * found.front.points[k].slip, 2),
                          fixed(degrees * found.rear.points[k].slip, 2),
                          !found.in_range[k] ? "beyond the linear range"
                          : kept             ? ""
                                             : "off the curve"});
  }
  return table.text();
}

// The measured tyres as a picture: side force over slip angle of both axles, the circles as points,
// the slope at zero slip with its uncertainty, the fitted curve, and the linear range.
namespace {

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
