// The daemon, its mode, the pose, and the timing of the beat.
#include <algorithm>
#include <array>
#include <cctype>
#include <cmath>
#include <sstream>

#include <fmt/format.h>

#include "tools/cli/text.hpp"
#include "tools/diagnostics/conditions.hpp"
#include "tools/drive_files/pose_csv.hpp"
#include "tools/live/status_value.hpp"
#include "tools/live/watch/draw.hpp"
#include "tools/live/watch/pictures.hpp"

namespace odomd::tools::watch {
namespace {

constexpr std::size_t pose_columns = 43;
constexpr std::size_t least_map = 20;

struct ModeInWords {
  Style style;
  std::string_view meaning;
};

ModeInWords in_words(std::uint32_t mode) {
  constexpr std::array<ModeInWords, 6> modes{{
      {Style::warning, "no initial pose or no wheel speed yet"},
      {Style::good, "camera poses are coming in"},
      {Style::good, "odometry alone"},
      {Style::warning, "it works, but something is missing:"},
      {Style::good, "the car stands"},
      {Style::bad, "the pose is frozen or invalid: do not use it"},
  }};
  static_assert(ODOM_INITIALISING == 0 && ODOM_FAULT == modes.size() - 1);
  return mode < modes.size()
             ? modes[mode]
             : ModeInWords{Style::warning, "unknown mode: is this odom older than odomd?"};
}

// "DEAD RECKONING"
std::string loud(std::string mode) {
  for (char& c : mode) c = c == '_' ? ' ' : static_cast<char>(std::toupper(c));
  return mode;
}

std::string seconds_in_words(std::int64_t ns) {
  return duration_in_words(1e-9 * static_cast<double>(ns));
}

Line who(const State& state, const Page& page) {
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
  return {{on + loud(mode_name(segment.pose.mode)) + "  ", style}, {std::string{meaning}}};
}

// "  x        12.345 m     ± 0.012"
Line quantity(std::string_view name, double value, std::string_view unit, double sigma,
              int decimals, const Page& page) {
  Line line{{fmt::format("  {:<9}", name), Style::dim},
            {fmt::format("{:>10}", fixed(value, decimals)), Style::strong},
            {fmt::format(" {:<6}", unit)}};
  if (std::isfinite(sigma))
    line.push_back({fmt::format("{}{}", glyph(page, "± ", "+- "), fixed(sigma, decimals))});
  return line;
}

double sigma_of(double variance) {
  return variance > 0.0 ? std::sqrt(variance) : 0.0;
}

Line label(std::string_view name, std::string text) {
  return {{fmt::format("  {:<11}", name), Style::dim}, {std::move(text)}};
}

Lines numbers(const State& state, const Page& page) {
  const odom_pose& pose = state.segment->pose;
  const odom_details& details = state.segment->details;
  const auto& P = pose.covariance;              // xx, xy, xyaw, yy, yyaw, yawyaw
  const auto& V = details.velocity_covariance;  // vx-vx, vy-vy, yaw_rate-yaw_rate: 9, 12, 14
  const std::string_view degree = glyph(page, "°", "deg");
  const std::string_view degree_per_s = glyph(page, "°/s", "deg/s");

  const Ellipse ellipse = ellipse_of({P[0], P[1], P[3]}, 3.0);
  const std::string size = fmt::format(
      "{} {} {} cm at {} {}", fixed(100.0 * ellipse.long_half_axis, 1), glyph(page, "×", "x"),
      fixed(100.0 * ellipse.short_half_axis, 1), fixed(ellipse.direction * degrees, 0), degree);
  const std::int64_t camera = details.dead_reckoning_since_ns;
  const std::string last_camera =
      camera == 0 ? "none fused yet" : seconds_in_words(pose.time_ns - camera) + " ago";
  Lines lines{quantity("x", pose.x, "m", sigma_of(P[0]), 3, page),
              quantity("y", pose.y, "m", sigma_of(P[3]), 3, page),
              quantity("yaw", heading(pose.yaw), degree, sigma_of(P[5]) * degrees, 2, page),
              label(glyph(page, "3σ", "3 sigma"), size),
              quantity("forward", pose.vx, "m/s", sigma_of(V[9]), 3, page),
              quantity("to left", pose.vy, "m/s", sigma_of(V[12]), 3, page),
              quantity("yaw rate", pose.yaw_rate * degrees, degree_per_s, sigma_of(V[14]) * degrees,
                       2, page),
              quantity("steering", pose.steering * degrees, degree, NAN, 2, page),
              label("camera", last_camera)};
  std::string jumps = std::to_string(pose.reset_count);
  if (pose.reset_count > 0)
    jumps +=
        fmt::format(", the last by {} cm", fixed(100.0 * std::hypot(pose.jump_x, pose.jump_y), 1));
  lines.push_back(label("jumps", jumps));
  return lines;
}

// A condition and its meaning, on as many lines as it needs.
void append_condition(Lines& lines, const Condition& condition, const Page& page) {
  Line line{{fmt::format("   {}", condition.name), Style::warning}, {" "}};
  std::istringstream words{std::string{condition.meaning}};
  for (std::string word; words >> word;) {
    if (width(line) + 1 + width(word) > page.columns) {
      lines.push_back(std::move(line));
      line = {{"     "}};
    }
    line.back().text += ' ' + word;
  }
  lines.push_back(std::move(line));
}

constexpr std::size_t label_columns = 10;

// Microseconds with as many decimals as are significant; from 10 ms on in milliseconds.
std::string time_of(const StatusValue& time) {
  const double us = time.value();
  if (us < 10'000.0) return time.number(us < 10.0 ? 1 : 0);
  return time.number(us < 100'000.0 ? 1 : 0, 1e-3) + " ms";
}

// "median 12  99.9 % 120  max 6799 µs", from the percentiles of the status.
std::string percentiles(const StatusValue& times, const Page& page) {
  const std::string max = time_of(times["max"]);
  return fmt::format("  median {}  99.9 % {}  max {}{}", time_of(times["p50"]),
                     time_of(times["p999"]), max,
                     max.ends_with(" ms") ? "" : glyph(page, " µs", " us"));
}

void append_histogram(Lines& lines, std::string_view name, Histogram histogram,
                      const StatusValue& times, std::size_t buckets_a_column, const Page& page) {
  const auto rows = bars(histogram, buckets_a_column, page.bar_rows, page.glyphs);
  for (std::size_t row = 0; row < rows.size(); ++row) {
    const bool last = row + 1 == rows.size();
    Line line{{fmt::format("  {:<{}}", last ? name : "", label_columns - 2), Style::dim},
              {rows[row], Style::accent}};
    if (last && times.exists()) line.push_back({percentiles(times, page)});
    lines.push_back(std::move(line));
  }
}

Line realtime_line(const StatusValue& realtime) {
  const double priority = realtime["priority"].value();
  const bool locked = realtime["memory_locked"].is_true();
  return {
      {"  runs as ", Style::dim},
      {priority > 0.0 ? fmt::format("SCHED_FIFO {}", priority) : "an ordinary thread",
       priority > 0.0 ? Style::plain : Style::warning},
      {locked ? ", memory locked" : ", memory not locked", locked ? Style::plain : Style::warning},
      {realtime["dma_latency_held"].is_true() ? ", cpu_dma_latency held"
                                              : ", cpu_dma_latency not held"}};
}

}  // namespace

Lines who_and_mode(const State& state, const Page& page) {
  Lines lines{who(state, page), mode_line(state, page)};
  if (!state.segment) {
    if (!state.segment_problem.empty())
      lines.push_back({{"   " + state.segment_problem, Style::dim}});
    return lines;
  }
  for (const Condition& condition : conditions_in(state.segment->pose.conditions))
    append_condition(lines, condition, page);
  if (state.restarts > 0)
    lines.push_back(
        {{fmt::format("   odomd has restarted {} meanwhile", counted(state.restarts, "time")),
          Style::dim}});
  return lines;
}

Lines pose_section(const State& state, const Page& page) {
  if (!state.segment) return {};
  const odom_pose& pose = state.segment->pose;
  const bool with_map = page.map_rows > 0 && page.columns >= pose_columns + least_map;
  std::string note = fmt::format("tick {}", pose.tick);
  if (with_map && !state.trail.points().empty())
    note +=
        fmt::format("{}the last {} m", glyph(page, " · ", ", "), fixed(state.trail.length(), 1));
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
  } else if (page.columns >= 2 * (pose_columns - 4)) {  // two halves, without blanks at the right
    const auto half = block.begin() + static_cast<std::ptrdiff_t>(block.size() / 2);
    block = side_by_side({block.begin(), half}, {half, block.end()}, page.columns / 2);
  }
  lines.insert(lines.end(), block.begin(), block.end());
  return lines;
}

Lines beat_section(const State& state, const Page& page) {
  if (!state.segment) return {};
  const odom_beat& beat = state.segment->beat;
  const StatusValue reported = state.reported()["beat"];
  const StatusValue realtime = state.reported()["realtime"];
  const std::string_view between = glyph(page, " · ", ", ");
  std::string note;
  if (reported.exists()) note = fmt::format("{} Hz{}", reported["ticks"].rate(), between);
  note += fmt::format("{} ticks{}{} missed{}{} overruns", beat.ticks, between, beat.missed, between,
                      beat.overruns);
  Lines lines{title("beat", note, page)};
  if (page.bar_rows == 0) return lines;
  constexpr std::size_t right_of_bars = 36;  // width of the percentiles
  const std::size_t buckets_a_column =
      page.columns >= label_columns + ODOM_HISTOGRAM_BUCKETS + right_of_bars ? 1 : 2;
  append_histogram(lines, "late by", beat.wakeup, reported["wakeup_us"], buckets_a_column, page);
  append_histogram(lines, "works", beat.execution, reported["execution_us"], buckets_a_column,
                   page);
  lines.push_back(
      {{std::string(label_columns, ' ') + axis(buckets_a_column, page.glyphs), Style::dim}});
  if (realtime.exists()) lines.push_back(realtime_line(realtime));
  return lines;
}

}  // namespace odomd::tools::watch
