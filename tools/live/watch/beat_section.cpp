// The timing of the beat.
#include "tools/cli/text.hpp"
#include "tools/live/watch/draw.hpp"
#include "tools/live/watch/pictures.hpp"

namespace odomd::watch {
namespace {

using tools::Json;
using tools::member;

constexpr std::size_t label_columns = 10;

// Microseconds with as many decimals as say something, milliseconds from ten on.
std::string time_of(const Json& value) {
  if (value.is_null()) return "-";
  const double us = value.get<double>();
  if (us >= 10'000.0) return tools::fixed(us / 1000.0, us < 100'000.0 ? 1 : 0) + " ms";
  return tools::fixed(us, us < 10.0 ? 1 : 0);
}

// "median 12  99.9 % 120  max 6799 µs", by the percentiles of the status.
std::string percentiles(const Json& times, const Page& page) {
  if (!times.is_object()) return {};
  std::string text = "  median " + time_of(member(times, "p50")) + "  99.9 % " +
                     time_of(member(times, "p999")) + "  max " + time_of(member(times, "max"));
  if (!text.ends_with(" ms")) text += glyph(page, " µs", " us");
  return text;
}

void append_histogram(Lines& lines, std::string_view name, Histogram histogram, const Json& times,
                      std::size_t buckets_a_column, const Page& page) {
  const auto rows = bars(histogram, buckets_a_column, page.bar_rows, page.glyphs);
  for (std::size_t row = 0; row < rows.size(); ++row) {
    const bool last = row + 1 == rows.size();
    std::string label = last ? "  " + std::string{name} : "";
    label.append(label_columns - label.size(), ' ');
    Line line{{label, Style::dim}, {rows[row], Style::accent}};
    if (last) line.push_back({percentiles(times, page)});
    lines.push_back(std::move(line));
  }
}

Lines realtime(const Json& status) {
  Lines lines;
  const Json& realtime = member(status, "realtime");
  if (!realtime.is_object()) return lines;
  const Json& priority = member(realtime, "priority");
  const int level = priority.is_number() ? priority.get<int>() : 0;
  Line line{{"  runs as ", Style::dim},
            {level > 0 ? "SCHED_FIFO " + std::to_string(level) : "an ordinary thread",
             level > 0 ? Style::plain : Style::warning}};
  const bool locked = tools::is_true(member(realtime, "memory_locked"));
  line.push_back(
      {locked ? ", memory locked" : ", memory not locked", locked ? Style::plain : Style::warning});
  const bool held = tools::is_true(member(realtime, "dma_latency_held"));
  line.push_back({held ? ", cpu_dma_latency held" : ", cpu_dma_latency not held"});
  lines.push_back(std::move(line));
  return lines;
}

// Ticks a second, by the counts of the two documents.
std::string rate(const State& state) {
  if (!state.status) return "";
  const Json& beat = member(*state.status, "beat");
  if (!beat.is_object()) return "";
  const tools::Rates rates{*state.status, state.before};
  return rates.of(member(beat, "ticks"), member(member(rates.before(), "beat"), "ticks")) + " Hz";
}

}  // namespace

Lines beat_section(const State& state, const Page& page) {
  if (!state.segment) return {};
  const odom_beat& beat = state.segment->beat;
  const std::string between{glyph(page, " · ", ", ")};
  std::string note;
  Json wakeup;
  Json execution;
  Lines scheduling;
  try {
    note = rate(state);
    if (state.status) {
      const Json& times = member(*state.status, "beat");
      wakeup = member(times, "wakeup_us");
      execution = member(times, "execution_us");
      scheduling = realtime(*state.status);
    }
  } catch (const Json::exception&) {
    note.clear();  // said once, where the rest of the status would be
  }
  note += (note.empty() ? "" : between) + std::to_string(beat.ticks) + " ticks" + between +
          std::to_string(beat.missed) + " missed" + between + std::to_string(beat.overruns) +
          " overruns";

  Lines lines{title("beat", note, page)};
  if (page.bar_rows == 0) return lines;
  constexpr std::size_t right_of_bars = 36;  // the percentiles
  const std::size_t buckets_a_column =
      page.columns >= label_columns + ODOM_HISTOGRAM_BUCKETS + right_of_bars ? 1 : 2;
  append_histogram(lines, "late by", beat.wakeup, wakeup, buckets_a_column, page);
  append_histogram(lines, "works", beat.execution, execution, buckets_a_column, page);
  lines.push_back(
      {{std::string(label_columns, ' ') + axis(buckets_a_column, page.glyphs), Style::dim}});
  lines.insert(lines.end(), scheduling.begin(), scheduling.end());
  return lines;
}

}  // namespace odomd::watch
