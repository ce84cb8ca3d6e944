#include "tools/live/status_value.hpp"

#include <algorithm>
#include <array>
#include <functional>
#include <utility>
#include <vector>

#include <fmt/format.h>

#include "tools/cli/text.hpp"

namespace odomd::tools {
namespace {

using Rows = std::vector<StatusValue>;

struct Column {
  std::string title;
  std::function<StyledText(const StatusValue& row)> cell;
  bool flush_left = false;
};

// A column with the value at `path` of each row.
Column column(std::string title, std::string path,
              std::string (StatusValue::*in_words)() const = &StatusValue::text) {
  return {std::move(title), [path = std::move(path), in_words](const StatusValue& row) {
            return StyledText{(row[path].*in_words)()};
          }};
}

Column left(Column column) {
  column.flush_left = true;
  return column;
}

// Cells line up, with the titles above them unless all are empty. No lines if there are no rows.
Lines table_of(const std::vector<Column>& columns, const Rows& rows) {
  if (rows.empty()) return {};
  Table table{.flush_left = {}};
  Lines lines(1);
  for (const Column& column : columns) {
    if (column.flush_left) table.flush_left.push_back(table.header.size());
    table.header.push_back(column.title);
    lines[0].push_back({"", Style::dim});
  }
  for (const StatusValue& row : rows) {
    lines.emplace_back();
    table.rows.emplace_back();
    for (const Column& column : columns) {
      lines.back().push_back(column.cell(row));
      table.rows.back().push_back(lines.back().back().text);
    }
  }
  const auto aligned = table.aligned();
  for (std::size_t row = 0; row < lines.size(); ++row)
    for (std::size_t i = 0; i < columns.size(); ++i)
      lines[row][i].text = (i == 0 ? "" : "  ") + aligned[row][i];
  if (as_text(lines[0]).empty()) lines.erase(lines.begin());
  return lines;
}

// ", 2 lost, 1 times down": the counts that are not 0.
StyledText nonzero(const StatusValue& counts, Style style,
                   std::initializer_list<std::pair<const char*, const char*>> names) {
  std::string text;
  for (const auto& [key, name] : names)
    if (const std::uint64_t count = counts[key].count(); count > 0)
      text += fmt::format(", {} {}", count, name);
  return {text, style};
}

bool is_unused(const StatusValue& source) {
  return source["verdicts/source_off"].count() > 0 && source["verdicts/fused"].count() == 0;
}

StyledText last_verdict(const StatusValue& source) {
  if (is_unused(source)) return {"unused by the model", Style::dim};
  const std::string last = source["last_verdict"].text();
  const bool fine = last == "fused" || last == "source_off" || last == "none";
  const StatusValue ratio = source["test_ratio"];
  return {last + (ratio.exists() ? ' ' + ratio.number(2) : ""),
          fine ? Style::plain : Style::warning};
}

// On a page narrower than 96 columns the innovations would push out the counts of samples that were
// not fused.
Lines sources(Rows sources, std::size_t columns_of_page) {
  std::erase_if(sources, [](const StatusValue& source) { return !source["configured"].is_true(); });
  std::vector<Column> columns{left(column("source", "name")),
                              {"state",
                               [](const StatusValue& source) {
                                 return StyledText{source_state(source), source["healthy"].is_true()
                                                                             ? Style::good
                                                                             : Style::bad};
                               },
                               true},
                              column("1/s", "verdicts", &StatusValue::rate),
                              column("age", "age_s", &StatusValue::duration),
                              column("fused", "verdicts/fused"),
                              {"last", last_verdict, true}};
  if (columns_of_page >= 96 && std::ranges::any_of(sources, [](const StatusValue& source) {
        return source["innovations/mean_nis"].exists();
      })) {
    columns.push_back(
        {"NIS", [](const auto& source) { return StyledText{nis_by_expectation(source)}; }});
    columns.push_back({"in 95 %", [](const auto& source) {
                         return StyledText{source["innovations/inside_95"].number(1, 100.0)};
                       }});
  }
  columns.push_back(
      {"not fused",
       [](const StatusValue& source) {
         return StyledText{source["verdicts"].nonzero({"fused", "source_off"}), Style::warning};
       },
       true});
  return table_of(columns, sources);
}

std::string beat_note(const StatusValue& beat) {
  if (!beat.exists()) return "";
  return fmt::format("{} Hz · {} · {} missed · {}{}", beat["ticks"].rate(),
                     beat["ticks"].counted("tick"), beat["missed"].text(),
                     beat["overruns"].counted("overrun"),
                     nonzero(beat, Style::plain, {{"carried_over", "carried over"}}).text);
}

// Microseconds with as many decimals as are significant; from 10 ms on in milliseconds.
std::string time_of(const StatusValue& time) {
  const double us = time.value();
  if (us < 10'000.0) return time.number(us < 10.0 ? 1 : 0);
  return time.number(us < 100'000.0 ? 1 : 0, 1e-3) + " ms";
}

// The beat's times since the start, and what the machine granted.
Lines beat(const StatusValue& status) {
  Lines lines;
  const StatusValue beat = status["beat"], realtime = status["realtime"];
  if (beat["last_overrun_age_s"].exists())
    lines.push_back({{fmt::format("last overrun {} ago: that tick worked for {} µs",
                                  beat["last_overrun_age_s"].duration(),
                                  beat["last_overrun_execution_us"].number(0)),
                      Style::warning}});
  for (const auto& [key, label] : {std::pair{"wakeup_us", "wake-up late by   "},
                                   std::pair{"execution_us", "a tick works for  "}}) {
    const StatusValue times = beat[key];
    if (!times.exists()) continue;
    const std::string max = time_of(times["max"]);
    lines.push_back({{label, Style::dim},
                     {fmt::format("median {}  99 % {}  99.9 % {}  max {}{}", time_of(times["p50"]),
                                  time_of(times["p99"]), time_of(times["p999"]), max,
                                  max.ends_with(" ms") ? "" : " µs")}});
  }
  if (!realtime.exists()) return lines;
  const double priority = realtime["priority"].value();
  const bool locked = realtime["memory_locked"].is_true();
  lines.push_back(
      {{"runs as ", Style::dim},
       {priority > 0.0 ? fmt::format("SCHED_FIFO {}", priority) : "an ordinary thread",
        priority > 0.0 ? Style::plain : Style::warning},
       {locked ? ", memory locked" : ", memory not locked", locked ? Style::plain : Style::warning},
       {realtime["dma_latency_held"].is_true() ? ", cpu_dma_latency held"
                                               : ", cpu_dma_latency not held"},
       nonzero(status["clock"], Style::warning,
               {{"steps", "steps of the wall clock"}, {"suspends", "suspends"}})});
  for (const StatusValue& refusal : realtime["refusals"].elements())
    lines.push_back({{"refused: " + refusal.text(), Style::warning}});
  return lines;
}

struct Unit {
  std::string_view calibration;
  std::string_view name;
  double factor;
};

// A scale has no unit.
Unit unit_of(const StatusValue& calibration) {
  constexpr std::array with_unit{
      Unit{"gyro_bias", " deg/s", degrees}, Unit{"accel_bias_x", " m/s2", 1.0},
      Unit{"accel_bias_y", " m/s2", 1.0},   Unit{"steering_offset", " deg", degrees},
      Unit{"gyro_latency", " ms", 1e3},     Unit{"wheel_latency", " ms", 1e3},
      Unit{"steering_latency", " ms", 1e3}, Unit{"grip", " m/s2", 1.0}};
  const auto* const found =
      std::ranges::find(with_unit, calibration["name"].text(), &Unit::calibration);
  return found == with_unit.end() ? Unit{"", "", 1.0} : *found;
}

// The calibrations that the model estimates.
Lines calibrations(Rows calibrations) {
  std::erase_if(calibrations, [](const StatusValue& one) { return !one["sigma"].exists(); });
  const auto value = [](const StatusValue& calibration) {
    return StyledText{calibration["value"].number(4, unit_of(calibration).factor), Style::strong};
  };
  const auto sigma = [](const StatusValue& calibration) {
    const Unit unit = unit_of(calibration);
    return StyledText{
        fmt::format("± {}{}", calibration["sigma"].number(4, unit.factor), unit.name)};
  };
  const auto learnt = [](const StatusValue& calibration) {
    return calibration["valid"].is_true() ? StyledText{"learnt", Style::good}
                                          : StyledText{"not yet", Style::dim};
  };
  return table_of({left(column("", "name")), {"", value}, {"", sigma, true}, {"", learnt, true}},
                  calibrations);
}

Lines camera(const StatusValue& camera) {
  if (!camera.exists() || camera["socket"].text().empty()) return {};
  Line line{{camera["messages"].rate() + " poses/s"}};
  if (const StatusValue latency = camera["last_latency_s"]; latency.exists())
    line.push_back({fmt::format(", the last one {} late", latency.duration())});
  const std::size_t connections = camera["connections"].elements().size();
  line.push_back({", " + counted(connections, "connection"),
                  connections == 0 ? Style::warning : Style::plain});
  line.push_back(nonzero(camera, Style::warning, {{"malformed", "malformed"}}));
  return {line};
}

// State, modes and errors of a controller.
Line controller_line(const StatusValue& controller) {
  const std::string state = controller["state"].text();
  const bool noisy = state == "error_warning" || state == "sleeping";
  std::string shown = state;
  std::ranges::replace(shown, '_', '-');
  Line line{{"  controller ", Style::dim},
            {shown, state == "error_active" ? Style::good
                    : noisy                 ? Style::warning
                                            : Style::bad}};
  std::string rest;
  for (const StatusValue& mode : controller["modes"].elements()) rest += ", " + mode.text();
  rest +=
      fmt::format(", tx {} rx {}", controller["tx_errors"].text(), controller["rx_errors"].text());
  if (const StatusValue timing = controller["bit_timing"]; timing.exists())
    rest +=
        fmt::format(", {} kbit/s at {} %",
                    timing["bitrate"].exists() ? shortest(1e-3 * timing["bitrate"].value()) : "-",
                    timing["sample_point"].number(1, 100.0));
  line.push_back({rest});
  // Without restart_ms a controller that went bus-off stays so for ever.
  if (const StatusValue restart = controller["restart_ms"]; restart.exists())
    line.push_back(
        {", restart-ms " + restart.text(), restart.count() == 0 ? Style::warning : Style::plain});
  line.push_back(nonzero(controller, Style::warning,
                         {{"bus_errors", "bus errors"},
                          {"error_passives", "times error-passive"},
                          {"bus_offs", "times bus-off"},
                          {"restarts", "restarts"}}));
  return line;
}

Lines buses(const Rows& buses) {
  Lines lines;
  for (const StatusValue& bus : buses) {
    const std::string link = bus["link"].text();
    lines.push_back(
        {{bus["name"].text() + ' ', Style::strong},
         {link, link == "up" ? Style::good : Style::bad},
         {fmt::format(", {} frames/s, {} in all", bus["received"].rate(), bus["received"].text())},
         nonzero(bus, Style::warning,
                 {{"lost", "lost"},
                  {"error_frames", "error frames"},
                  {"malformed", "malformed lines"},
                  {"controller_overflows", "controller overflows"},
                  {"bus_offs", "times bus-off"},
                  {"link_downs", "times down"}}),
         nonzero(bus, Style::plain,
                 {{"stamp_fallbacks", "stamped when read"},
                  {"hardware_fallbacks", "without a hardware stamp"}})});
    if (bus["controller"].exists()) lines.push_back(controller_line(bus["controller"]));
  }
  return lines;
}

Lines messages(const Rows& messages) {
  const auto refused = [](const StatusValue& message) {
    std::string text = message["verdicts"].nonzero({"decoded", "unmapped", "no_sample"});
    if (const std::uint64_t lost = message["some_lost"].count(); lost > 0)
      text += fmt::format("{}{} after a gap", text.empty() ? "" : ", ", lost);
    return StyledText{text, Style::warning};
  };
  return table_of({left(column("message", "name")),
                   left(column("id", "id", &StatusValue::hexadecimal)),
                   column("1/s", "verdicts", &StatusValue::rate),
                   column("age", "age_s", &StatusValue::duration),
                   column("decoded", "verdicts/decoded"),
                   {"refused", refused, true}},
                  messages);
}

// The sigmas of the sources' samples, if the model estimates them.
Lines noise(Rows sources) {
  std::erase_if(sources, [](const StatusValue& source) {
    const StatusValue noise = source["noise"];
    return !noise["at_rest"].exists() && !noise["moving"].exists() &&
           !noise["speed_share"].exists();
  });
  const auto unit = [](const StatusValue& source) {
    const std::string name = source["name"].text();
    return StyledText{name == "yaw_rate" ? "rad/s" : name.starts_with("accel") ? "m/s2" : "m/s"};
  };
  const auto share = [](const StatusValue& source) {
    const StatusValue part = source["noise/speed_share"];
    return StyledText{part.number(2, 100.0) + (part.exists() ? " %" : "")};
  };
  constexpr auto significant = &StatusValue::significant;
  return table_of({left(column("source", "name")),
                   {"unit", unit, true},
                   column("stated", "sigma", significant),
                   column("at rest", "noise/at_rest", significant),
                   column("moving", "noise/moving", significant),
                   {"of speed", share}},
                  sources);
}

}  // namespace

Line title(std::string_view name, std::string_view note, std::size_t columns) {
  Line line{{"── ", Style::dim}, {std::string{name} + ' ', Style::strong}};
  if (!note.empty()) line.push_back({fmt::format(" {} ", note), Style::plain});
  std::string rule;
  for (std::size_t i = width(line); i < columns; ++i) rule += "─";
  line.push_back({rule, Style::dim});
  return line;
}

Lines status_sections(const StatusValue& status, std::size_t columns) {
  Lines all;
  const auto add = [&](std::string_view name, std::string_view note, Lines lines) {
    if (lines.empty() && note.empty()) return;
    all.push_back(title(name, note, columns));
    for (Line& line : lines) {
      line.insert(line.begin(), {"  "});
      all.push_back(std::move(line));
    }
  };
  const Rows all_sources = status["sources"].elements();
  const std::string camera_socket =
      status["camera"].exists() ? status["camera/socket"].text() : std::string{};
  add("sources", "", sources(all_sources, columns));
  add("beat", beat_note(status["beat"]), beat(status));
  add("calibration", "", calibrations(status["calibrations"].elements()));
  add("camera", camera_socket, camera(status["camera"]));
  add("bus", "", buses(status["can"].elements()));
  add("messages", "", messages(status["messages"].elements()));
  add("noise", "", noise(all_sources));
  return all;
}

}  // namespace odomd::tools
