// The sections from the status document: sources, calibrations, camera, buses and messages.
#include <array>

#include <fmt/format.h>

#include "tools/cli/text.hpp"
#include "tools/live/status_table.hpp"
#include "tools/live/watch/draw.hpp"

namespace odomd::tools::watch {
namespace {

// On a narrower page the innovations would push out the counts of samples that were not fused.
constexpr std::size_t with_innovations = 96;

// Appends a section, unless it is empty.
void append(Lines& all, std::string_view name, std::string_view note, Lines lines,
            const Page& page) {
  if (lines.empty()) return;
  all.push_back(title(name, note, page));
  for (Line& line : lines) {
    line.insert(line.begin(), {"  "});
    all.push_back(std::move(line));
  }
}

// "500 kbit/s", "125.5 kbit/s".
std::string bit_rate(const StatusValue& rate) {
  if (!rate.exists()) return "-";
  return rate.number(rate.count() % 1000 == 0 ? 0 : 1, 1e-3) + " kbit/s";
}

// State, modes and errors of a controller.
Line controller_line(const StatusValue& controller) {
  const std::string state = controller["state"].text();
  const bool noisy = state == "error_warning" || state == "sleeping";
  Line line{{"  controller ", Style::dim},
            {hyphenated(state), state == "error_active" ? Style::good
                                : noisy                 ? Style::warning
                                                        : Style::bad}};
  std::string rest =
      fmt::format(", tx {} rx {}", controller["tx_errors"].text(), controller["rx_errors"].text());
  if (const StatusValue timing = controller["bit_timing"]; timing.exists())
    rest += fmt::format(", {} at {} %", bit_rate(timing["bitrate"]),
                        timing["sample_point"].number(1, 100.0));
  line.push_back({rest});
  // Without restart_ms a controller that went bus-off stays so for ever.
  if (const StatusValue restart = controller["restart_ms"]; restart.exists())
    line.push_back(
        {", restart-ms " + restart.text(), restart.count() == 0 ? Style::warning : Style::plain});
  return line;
}

Lines buses(const StatusValue& status) {
  Lines lines;
  for (const StatusValue& bus : status["can"].elements()) {
    const std::string link = bus["link"].text();
    Line line{
        {bus["name"].text() + ' ', Style::strong},
        {link, link == "up" ? Style::good : Style::bad},
        {fmt::format(", {} frames/s, {} in all", bus["received"].rate(), bus["received"].text())}};
    constexpr std::array wrong{std::pair{"lost", "lost"},
                               std::pair{"error_frames", "error frames"},
                               std::pair{"malformed", "malformed lines"},
                               std::pair{"controller_overflows", "controller overflows"},
                               std::pair{"bus_offs", "times bus-off"},
                               std::pair{"link_downs", "times down"}};
    for (const auto& [key, name] : wrong)
      if (const std::uint64_t count = bus[key].count(); count > 0)
        line.push_back({fmt::format(", {} {}", count, name), Style::warning});
    lines.push_back(std::move(line));
    if (bus["controller"].exists()) lines.push_back(controller_line(bus["controller"]));
  }
  return lines;
}

Lines camera_line(const StatusValue& camera) {
  if (!camera.exists() || camera["socket"].text().empty()) return {};
  Line line{{camera["messages"].rate() + " poses/s"}};
  if (const StatusValue latency = camera["last_latency_s"]; latency.exists())
    line.push_back({fmt::format(", the last one {} late", latency.duration())});
  const std::size_t connections = camera["connections"].elements().size();
  line.push_back({", " + counted(connections, "connection"),
                  connections == 0 ? Style::warning : Style::plain});
  if (const std::uint64_t malformed = camera["malformed"].count(); malformed > 0)
    line.push_back({fmt::format(", {} malformed", malformed), Style::warning});
  return {line};
}

}  // namespace

Lines status_sections(const State& state, const Page& page) {
  const StatusValue status = state.reported();
  const StatusValue instance = status["instance"];
  std::string problem = state.status_problem;
  if (state.segment && instance.exists() &&
      instance.text() != fmt::format("{:016x}", state.segment->info.instance_id))
    problem =
        state.socket + " belongs to another daemon than the pose; give both --shm and --socket";
  Lines all;
  if (!problem.empty()) append(all, "status", "", {{{problem, Style::warning}}}, page);
  const Form form = page.columns < with_innovations ? Form::screen : Form::wide_screen;
  append(all, "sources", "", source_table(status, form), page);
  append(all, "calibration", "", calibration_table(status, form, page.glyphs), page);
  append(all, "camera", status["camera/socket"].text(), camera_line(status["camera"]), page);
  append(all, "bus", "", buses(status), page);
  append(all, "messages", "", message_table(status, form), page);
  return all;
}

}  // namespace odomd::tools::watch
