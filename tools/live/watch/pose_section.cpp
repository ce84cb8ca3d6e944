// The daemon, its mode, and the pose.
#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <sstream>

#include "tools/cli/text.hpp"
#include "tools/diagnostics/conditions.hpp"
#include "tools/drive_files/pose_csv.hpp"
#include "tools/live/watch/draw.hpp"
#include "tools/live/watch/pictures.hpp"

namespace odomd::watch {
namespace {

using tools::degrees;
using tools::fixed;

constexpr std::size_t pose_columns = 43;
constexpr std::size_t least_map = 20;

struct ModeInWords {
  Style style;
  std::string_view meaning;
};

ModeInWords in_words(std::uint32_t mode) {
  switch (mode) {
    case ODOM_INITIALISING:
      return {Style::warning, "no initial pose or no wheel speed yet"};
    case ODOM_TRACKING:
      return {Style::good, "camera poses are coming in"};
    case ODOM_DEAD_RECKONING:
      return {Style::good, "odometry alone"};
    case ODOM_DEGRADED:
      return {Style::warning, "it works, but something is missing:"};
    case ODOM_STANDSTILL:
      return {Style::good, "the car stands"};
    case ODOM_FAULT:
      return {Style::bad, "the pose is frozen or invalid: do not use it"};
    default:
      return {Style::warning, "unknown mode: is this odom older than odomd?"};
  }
}

std::string upper(std::string text) {
  std::transform(text.begin(), text.end(), text.begin(),
                 [](char c) { return c >= 'a' && c <= 'z' ? static_cast<char>(c - 32) : c; });
  std::replace(text.begin(), text.end(), '_', ' ');
  return text;
}

std::string seconds_in_words(std::int64_t ns) {
  return tools::duration(tools::Json(static_cast<double>(ns) * 1e-9));
}

Line who(const State& state, const Page& page) {
  Line left{{" odomd ", Style::strong}};
  Line right;
  if (state.segment) {
    const odom_info& info = state.segment->info;
    left.push_back({std::string{info.version} + "  "});
    left.push_back({"model " + std::string{info.model} + "  ", Style::plain});
    right.push_back({"pid " + std::to_string(info.writer_pid) + "  up " +
                         seconds_in_words(state.now_ns - info.writer_start_ns) + ' ',
                     Style::dim});
  }
  if (state.status) {
    const tools::Json& config = tools::member(*state.status, "config");
    if (config.is_string()) left.push_back({config.get<std::string>(), Style::dim});
  }
  return justified(std::move(left), right, page.columns);
}

Line mode_line(const State& state, const Page& page) {
  const std::string on{glyph(page, " ● ", " * ")};
  const std::string off{glyph(page, " ○ ", " o ")};
  if (!state.segment) {
    return {{off + "WAITING  ", Style::warning}, {"for odomd at " + state.segment_name}};
  }
  const Segment& segment = *state.segment;
  if (segment.silent) {
    return {{off + "SILENT  ", Style::bad},
            {"no tick for " +
             seconds_in_words(std::max(state.now_ns - segment.beat.heartbeat_ns, std::int64_t{0})) +
             "; waiting for odomd at " + state.segment_name}};
  }
  const auto [style, meaning] = in_words(segment.pose.mode);
  return {{on + upper(tools::mode_name(segment.pose.mode)) + "  ", style}, {std::string{meaning}}};
}

// "  x        12.345 m     ± 0.012"
Line quantity(std::string_view name, double value, std::string_view unit, double sigma,
              int decimals, const Page& page) {
  constexpr std::size_t name_columns = 11;
  constexpr std::size_t value_columns = 10;
  constexpr std::size_t unit_columns = 7;
  std::string label = "  " + std::string{name};
  label.append(name_columns - std::min(name_columns, tools::width(label)), ' ');
  const std::string text = fixed(value, decimals);
  const std::string blanks(value_columns - std::min(value_columns, text.size()), ' ');
  std::string after = ' ' + std::string{unit};
  after.append(unit_columns - std::min(unit_columns, tools::width(after)), ' ');
  Line line{{label, Style::dim}, {blanks + text, Style::strong}, {after}};
  if (std::isfinite(sigma)) {
    line.push_back({std::string{glyph(page, "± ", "+- ")} + fixed(sigma, decimals)});
  }
  return line;
}

double sigma_of(double variance) {
  return variance > 0.0 ? std::sqrt(variance) : 0.0;
}

Line label(std::string_view name, std::string text) {
  std::string padded = "  " + std::string{name};
  padded.append(13 - std::min<std::size_t>(13, tools::width(padded)), ' ');
  return {{padded, Style::dim}, {std::move(text)}};
}

Lines numbers(const State& state, const Page& page) {
  const odom_pose& pose = state.segment->pose;
  const odom_details& details = state.segment->details;
  const auto& P = pose.covariance;              // xx, xy, xyaw, yy, yyaw, yawyaw
  const auto& V = details.velocity_covariance;  // vx-vx, vy-vy, yaw_rate-yaw_rate: 9, 12, 14
  const double yaw = std::remainder(pose.yaw, 2.0 * std::numbers::pi);
  const std::string_view degree = glyph(page, "°", "deg");
  const std::string_view degree_per_s = glyph(page, "°/s", "deg/s");

  const Ellipse ellipse = ellipse_of({P[0], P[1], P[3]}, 3.0);
  const std::string size = fixed(100.0 * ellipse.long_half_axis, 1) +
                           std::string{glyph(page, " × ", " x ")} +
                           fixed(100.0 * ellipse.short_half_axis, 1) + " cm at " +
                           fixed(ellipse.direction * degrees, 0) + ' ' + std::string{degree};
  const std::int64_t camera = details.dead_reckoning_since_ns;
  const std::string last_camera =
      camera == 0 ? "none fused yet" : seconds_in_words(pose.time_ns - camera) + " ago";
  Lines lines{quantity("x", pose.x, "m", sigma_of(P[0]), 3, page),
              quantity("y", pose.y, "m", sigma_of(P[3]), 3, page),
              quantity("yaw", yaw * degrees, degree, sigma_of(P[5]) * degrees, 2, page),
              label(glyph(page, "3σ", "3 sigma"), size),
              quantity("forward", pose.vx, "m/s", sigma_of(V[9]), 3, page),
              quantity("to left", pose.vy, "m/s", sigma_of(V[12]), 3, page),
              quantity("yaw rate", pose.yaw_rate * degrees, degree_per_s, sigma_of(V[14]) * degrees,
                       2, page),
              quantity("steering", pose.steering * degrees, degree, NAN, 2, page),
              label("camera", last_camera)};
  std::string jumps = std::to_string(pose.reset_count);
  if (pose.reset_count > 0) {
    jumps += ", the last by " + fixed(100.0 * std::hypot(pose.jump_x, pose.jump_y), 1) + " cm";
  }
  lines.push_back(label("jumps", jumps));
  return lines;
}

// Its meaning on as many lines as it takes.
void append_condition(Lines& lines, const tools::Condition& condition, const Page& page) {
  Line line{{"   " + std::string{condition.name}, Style::warning}, {" "}};
  std::istringstream words{std::string{condition.meaning}};
  for (std::string word; words >> word;) {
    if (width(line) + 1 + tools::width(word) > page.columns) {
      lines.push_back(std::move(line));
      line = {{"     "}};
    }
    line.back().text += ' ' + word;
  }
  lines.push_back(std::move(line));
}

}  // namespace

Lines who_and_mode(const State& state, const Page& page) {
  Lines lines{who(state, page), mode_line(state, page)};
  if (!state.segment) {
    if (!state.segment_problem.empty()) {
      lines.push_back({{"   " + state.segment_problem, Style::dim}});
    }
    return lines;
  }
  for (const tools::Condition& condition : tools::conditions_in(state.segment->pose.conditions))
    append_condition(lines, condition, page);
  if (state.restarts > 0) {
    lines.push_back({{"   odomd has restarted " + std::to_string(state.restarts) +
                          (state.restarts == 1 ? " time" : " times") + " meanwhile",
                      Style::dim}});
  }
  return lines;
}

Lines pose_section(const State& state, const Page& page) {
  if (!state.segment) return {};
  const odom_pose& pose = state.segment->pose;
  const bool with_map = page.map_rows > 0 && page.columns >= pose_columns + least_map;
  std::string note = "tick " + std::to_string(pose.tick);
  if (with_map && !state.trail.points().empty()) {
    note +=
        std::string{glyph(page, " · ", ", ")} + "the last " + fixed(state.trail.length(), 1) + " m";
  }
  Lines lines{title("pose", note, page)};
  if (pose.mode == ODOM_INITIALISING) {
    lines.push_back({{"  none yet", Style::dim}});
    return lines;
  }
  Lines block = numbers(state, page);
  if (with_map) {
    const std::size_t columns = page.columns - pose_columns - 1;
    block = side_by_side(
        block,
        draw_map(state.trail, pose, {columns, std::max(page.map_rows, block.size()), page.glyphs}),
        pose_columns);
  } else if (page.columns >= 2 * (pose_columns - 4)) {  // without the blanks between two halves
    const auto half = block.begin() + static_cast<std::ptrdiff_t>(block.size() / 2);
    block = side_by_side({block.begin(), half}, {half, block.end()}, page.columns / 2);
  }
  lines.insert(lines.end(), block.begin(), block.end());
  return lines;
}

}  // namespace odomd::watch
