#include "tools/live/watch/page.hpp"

#include <algorithm>
#include <cmath>
#include <sstream>

#include <fmt/format.h>

#include "daemon/core/conditions.hpp"
#include "tools/cli/text.hpp"
#include "tools/drive_files/pose_csv.hpp"
#include "tools/live/status_value.hpp"

namespace odomd::tools::watch {
namespace {

constexpr std::size_t pose_columns = 43;
constexpr std::size_t min_map_columns = 20;

struct ModeInWords {
  Style style;
  std::string_view meaning;
};

constexpr std::array<ModeInWords, 6> modes{{
    {Style::warning, "no initial pose or no wheel speed yet"},
    {Style::good, "camera poses are coming in"},
    {Style::good, "odometry alone"},
    {Style::warning, "it works, but something is missing:"},
    {Style::good, "the car stands"},
    {Style::bad, "the pose is frozen or invalid: do not use it"},
}};
static_assert(ODOM_INITIALISING == 0 && ODOM_FAULT == modes.size() - 1);

void append(Lines& lines, Lines more) {
  lines.insert(lines.end(), std::make_move_iterator(more.begin()),
               std::make_move_iterator(more.end()));
}

std::string seconds_in_words(std::int64_t ns) {
  return duration_in_words(1e-9 * static_cast<double>(ns));
}

Line who(const State& state, std::size_t columns) {
  Line left{{" odomd ", Style::strong}};
  Line right;
  if (state.segment) {
    const odom_info& info = state.segment->info;
    left.push_back({fmt::format("{}  model {}  ", info.version, info.model)});
    right.push_back({fmt::format("pid {}  up {} ", info.writer_pid,
                                 seconds_in_words(state.now_ns - info.writer_start_ns)),
                     Style::dim});
  }
  if (const StatusValue config = state.reported()["config"]; config.json().is_string())
    left.push_back({config.text(), Style::dim});
  return justified(std::move(left), right, columns);
}

// A condition and its meaning, on as many lines as it needs.
void append_condition(Lines& lines, const daemon::Condition& condition, std::size_t columns) {
  Line line{{fmt::format("   {}", condition.name), Style::warning}, {" "}};
  std::istringstream words{std::string{condition.meaning}};
  for (std::string word; words >> word;) {
    if (width(line) + 1 + width(word) > columns) {
      lines.push_back(std::move(line));
      line = {{"     "}};
    }
    line.back().text += ' ' + word;
  }
  lines.push_back(std::move(line));
}

// "  x        12.345 m     ± 0.012"
Line quantity(std::string_view name, double value, std::string_view unit, double variance,
              int decimals, double factor = 1.0) {
  Line line{{fmt::format("  {:<9}", name), Style::dim},
            {fmt::format("{:>10}", fixed(factor * value, decimals)), Style::strong},
            {fmt::format(" {:<6}", unit)}};
  if (std::isfinite(variance))
    line.push_back({"± " + fixed(factor * std::sqrt(std::max(variance, 0.0)), decimals)});
  return line;
}

Line label(std::string_view name, std::string text) {
  return {{fmt::format("  {:<11}", name), Style::dim}, {std::move(text)}};
}

Lines numbers(const Segment& segment) {
  const odom_pose& pose = segment.pose;
  const auto& P = pose.covariance;  // xx, xy, xyaw, yy, yyaw, yawyaw
  const auto& V =
      segment.details.velocity_covariance;  // vx-vx, vy-vy, yaw_rate-yaw_rate: 9, 12, 14
  Lines lines{
      quantity("x", pose.x, "m", P[0], 3),
      quantity("y", pose.y, "m", P[3], 3),
      quantity("yaw", std::remainder(pose.yaw, 2.0 * std::numbers::pi), "°", P[5], 2, degrees),
      quantity("forward", pose.vx, "m/s", V[9], 3),
      quantity("to left", pose.vy, "m/s", V[12], 3),
      quantity("yaw rate", pose.yaw_rate, "°/s", V[14], 2, degrees),
      quantity("steering", pose.steering, "°", NAN, 2, degrees)};
  if (std::isfinite(P[1])) {
    const Ellipse ellipse = ellipse_of({P[0], P[1], P[3]}, 3.0);
    lines.insert(
        lines.begin() + 3,
        label("3σ", fmt::format("{} × {} cm at {} °", fixed(100.0 * ellipse.long_half_axis, 1),
                                fixed(100.0 * ellipse.short_half_axis, 1),
                                fixed(ellipse.direction * degrees, 0))));
  }
  std::string jumps = std::to_string(pose.reset_count);
  if (const double jump = std::hypot(pose.jump_x, pose.jump_y); jump > 0.0)
    jumps += fmt::format(", the last by {} cm", fixed(100.0 * jump, 1));
  lines.push_back(label("jumps", jumps));
  return lines;
}

// What a status document says about the segment of its daemon. Velocities have no sigma, and the
// correlation of x and y is unknown.
Segment segment_reported(const StatusValue& status, std::int64_t now_ns) {
  const auto ns = [](const StatusValue& seconds) {
    return static_cast<std::int64_t>(1e9 * seconds.value());
  };
  Segment segment;
  const StatusValue from = status["pose"];
  odom_pose& pose = segment.pose;
  while (pose.mode < modes.size() && mode_name(pose.mode) != status["mode"].text()) ++pose.mode;
  for (const StatusValue& name : status["conditions"].elements())
    for (const daemon::Condition& condition : daemon::conditions)
      if (condition.name == name.text()) pose.conditions |= condition.bit;
  pose.tick = from["tick"].count();
  pose.covariance[1] = NAN;
  pose.time_ns = now_ns - ns(from["age_s"]);
  for (const auto& [key, member] : {std::pair{"x", &odom_pose::x},
                                    {"y", &odom_pose::y},
                                    {"yaw", &odom_pose::yaw},
                                    {"vx", &odom_pose::vx},
                                    {"vy", &odom_pose::vy},
                                    {"yaw_rate", &odom_pose::yaw_rate},
                                    {"steering", &odom_pose::steering}})
    pose.*member = from[key].value();
  for (const auto& [key, index] : {std::pair{"sigma_x", 0}, {"sigma_y", 3}, {"sigma_yaw", 5}})
    pose.covariance[index] = std::pow(from[key].value(), 2);
  pose.reset_count = static_cast<std::uint32_t>(from["reset_count"].count());
  std::ranges::fill(segment.details.velocity_covariance, NAN);
  odom_info& info = segment.info;
  fmt::format_to_n(info.version, sizeof info.version - 1, "{}", status["version"].text());
  fmt::format_to_n(info.model, sizeof info.model - 1, "{}", status["model"].text());
  info.writer_pid = static_cast<decltype(info.writer_pid)>(status["pid"].count());
  info.writer_start_ns = now_ns - ns(status["uptime_s"]);
  return segment;
}

// Shows the status document, or why there is none.
Lines status_of(const State& state, std::size_t columns) {
  const StatusValue status = state.reported();
  const StatusValue instance = status["instance"];
  std::string problem = state.status_problem;
  if (state.segment && instance.exists() &&
      instance.text() != fmt::format("{:016x}", state.segment->info.instance_id))
    problem =
        state.socket + " belongs to another daemon than the pose; give both --shm and --socket";
  Lines lines;
  if (!problem.empty()) lines = {title("status", "", columns), {{"  " + problem, Style::warning}}};
  append(lines, status_sections(status, columns));
  return lines;
}

// A larger screen gets a larger map.
Picture draw_all(const State& state, const View& view) {
  const std::size_t map_rows = view.rows >= 44 ? 15 : view.rows >= 30 ? 10 : 0;
  Picture picture{head(state, view.columns), pose_section(state, view.columns, map_rows)};
  append(picture.body, status_of(state, view.columns));
  return picture;
}

}  // namespace

Lines mode_lines(const State& state, std::size_t columns) {
  if (!state.segment)
    return {{{" ○ WAITING  ", Style::warning}, {"for odomd at " + state.segment_name}}};
  const Segment& segment = *state.segment;
  Lines lines;
  if (segment.silent) {
    lines.push_back(
        {{" ○ SILENT  ", Style::bad},
         {"no tick for " +
          seconds_in_words(std::max(state.now_ns - segment.beat.heartbeat_ns, std::int64_t{0})) +
          "; waiting for odomd at " + state.segment_name}});
  } else {
    const auto [style, meaning] =
        segment.pose.mode < modes.size()
            ? modes[segment.pose.mode]
            : ModeInWords{Style::warning, "unknown mode: is this odom older than odomd?"};
    lines.push_back(
        {{fmt::format(" ● {}  ", mode_name(segment.pose.mode)), style}, {std::string{meaning}}});
  }
  for (const daemon::Condition& condition : daemon::conditions_in(segment.pose.conditions))
    append_condition(lines, condition, columns);
  return lines;
}

Lines head(const State& state, std::size_t columns) {
  Lines lines{who(state, columns)};
  append(lines, mode_lines(state, columns));
  if (!state.segment && !state.segment_problem.empty())
    lines.push_back({{"   " + state.segment_problem, Style::dim}});
  if (state.restarts > 0)
    lines.push_back(
        {{fmt::format("   odomd has restarted {} meanwhile", counted(state.restarts, "time")),
          Style::dim}});
  return lines;
}

Lines pose_section(const State& state, std::size_t columns, std::size_t map_rows) {
  if (!state.segment) return {};
  const odom_pose& pose = state.segment->pose;
  if (pose.mode == ODOM_INITIALISING)
    return {title("pose", "", columns), {{"  none yet", Style::dim}}};
  Lines lines{title(
      "pose",
      fmt::format("tick {} · {} old", pose.tick, seconds_in_words(state.now_ns - pose.time_ns)),
      columns)};
  Lines block = numbers(*state.segment);
  if (map_rows > 0 && columns >= pose_columns + min_map_columns) {
    block = side_by_side(
        block,
        draw_map(state.trail, pose, columns - pose_columns - 1, std::max(map_rows, block.size())),
        pose_columns);
  } else if (columns >= 2 * (pose_columns - 4)) {  // two halves, without blanks at the right
    const auto half = block.begin() + static_cast<std::ptrdiff_t>(block.size() / 2);
    block = side_by_side({block.begin(), half}, {half, block.end()}, columns / 2);
  }
  append(lines, std::move(block));
  return lines;
}

std::string status_as_text(const Json& document, const std::optional<Json>& before) {
  State state{.status = document, .before = before};
  state.segment = segment_reported(state.reported(), state.now_ns);
  constexpr std::size_t columns = 100;
  return as_text(head(state, columns)) + as_text(pose_section(state, columns, 0)) +
         as_text(status_sections(state.reported(), columns));
}

Picture draw(const State& state, const View& view) {
  try {
    return draw_all(state, view);
  } catch (const Json::exception& error) {
    State without = state;
    without.status.reset();
    without.status_problem =
        fmt::format("cannot be parsed; are odom and odomd of the same version? ({})", error.what());
    return draw_all(without, view);
  }
}

std::size_t most_scrolled(const Picture& picture, const View& view) {
  const std::size_t around = picture.head.size() + 1;
  const std::size_t room = view.rows > around ? view.rows - around : 0;
  return picture.body.size() > room ? picture.body.size() - room : 0;
}

Lines screen(const Picture& picture, const View& view) {
  const std::size_t most = most_scrolled(picture, view);
  const std::size_t first = std::min(view.scrolled, most);
  Lines lines = picture.head;
  lines.insert(lines.end(), picture.body.begin() + static_cast<std::ptrdiff_t>(first),
               picture.body.end());
  lines.resize(view.rows - 1);

  Line keys{{" q ", Style::strong},
            {"quit  "},
            {"p ", Style::strong},
            {view.paused ? "continue  " : "pause  "}};
  if (view.paused) keys.push_back({"PAUSED  ", Style::warning});
  Line more;
  if (most > 0) {
    keys.insert(keys.end(), {{"↑↓ ", Style::strong}, {"scroll"}});
    const std::size_t below = most - first;
    more = {{below > 0 ? std::to_string(below) + " more lines below " : "the end ", Style::dim}};
  }
  lines.push_back(justified(keys, more, view.columns));
  for (Line& line : lines) line = fitted(line, view.columns);
  return lines;
}

}  // namespace odomd::tools::watch
