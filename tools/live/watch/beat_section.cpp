// The timing of the beat.
#include <fmt/format.h>

#include "tools/live/status_value.hpp"
#include "tools/live/watch/draw.hpp"
#include "tools/live/watch/pictures.hpp"

namespace odomd::tools::watch {
namespace {

constexpr std::size_t label_columns = 10;

// Microseconds with as many decimals as say something, milliseconds from ten on.
std::string time_of(const StatusValue& time) {
  const double us = time.value();
  if (us < 10'000.0) return time.number(us < 10.0 ? 1 : 0);
  return time.number(us < 100'000.0 ? 1 : 0, 1e-3) + " ms";
}

// "median 12  99.9 % 120  max 6799 µs", by the percentiles of the status.
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
  constexpr std::size_t right_of_bars = 36;  // the percentiles
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
