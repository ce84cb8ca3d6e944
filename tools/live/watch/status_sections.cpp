// The lists of the status document: sources, camera, buses, messages.
#include <algorithm>
#include <array>

#include "tools/cli/text.hpp"
#include "tools/live/watch/draw.hpp"

namespace odomd::watch {
namespace {

using tools::count;
using tools::duration;
using tools::is_true;
using tools::Json;
using tools::member;
using tools::word;

// Narrower, and the innovations would push out what was not fused.
constexpr std::size_t with_innovations = 96;

// A table of styled cells that line up; columns are flush right but for those in `left`.
struct Table {
  std::vector<std::vector<Span>> rows;
  std::vector<std::size_t> left;

  [[nodiscard]] Lines lines() const {
    Lines all = rows;
    tools::align_columns(all, left, [](Span& cell) -> std::string& { return cell.text; });
    for (Line& line : all)
      for (std::size_t i = line.size(); i-- > 0;)
        line.insert(line.begin() + static_cast<std::ptrdiff_t>(i), {"  "});
    return all;
  }
};

std::vector<Span> header(std::initializer_list<const char*> names) {
  std::vector<Span> cells;
  for (const char* name : names) cells.push_back({name, Style::dim});
  return cells;
}

Lines under(Line heading, const Table& table) {
  Lines lines{std::move(heading)};
  const Lines rows = table.lines();
  lines.insert(lines.end(), rows.begin(), rows.end());
  return lines;
}

std::uint64_t number_of(const Json& value) {
  return value.is_null() ? 0 : value.get<std::uint64_t>();
}

// The counts that are not 0: "3 gated, 1 too_old".
std::string counts_in_words(const Json& verdicts, std::initializer_list<std::string_view> without) {
  std::string text;
  for (const auto& [verdict, value] : verdicts.items()) {
    if (std::find(without.begin(), without.end(), verdict) != without.end()) continue;
    if (number_of(value) > 0)
      text += (text.empty() ? "" : ", ") + std::to_string(number_of(value)) + ' ' + verdict;
  }
  return text;
}

// "500 kbit/s", "125.5 kbit/s".
std::string bit_rate(const Json& value) {
  if (value.is_null()) return "-";
  const double kilo = value.get<double>() / 1000.0;
  return tools::fixed(kilo, kilo == static_cast<double>(static_cast<long>(kilo)) ? 0 : 1) +
         " kbit/s";
}

// What the controller says of itself, where there is one.
Line controller_line(const Json& controller) {
  const std::string state = word(member(controller, "state"));
  std::string name = state;
  std::replace(name.begin(), name.end(), '_', '-');
  const bool fine = state == "error_active";
  const bool noisy = state == "error_warning" || state == "sleeping";
  Line line{{"    controller ", Style::dim},
            {name, fine    ? Style::good
                   : noisy ? Style::warning
                           : Style::bad}};
  std::string rest = ", tx " + count(member(controller, "tx_errors")) + " rx " +
                     count(member(controller, "rx_errors"));
  if (const Json& timing = member(controller, "bit_timing"); timing.is_object())
    rest += ", " + bit_rate(member(timing, "bitrate")) + " at " +
            tools::number(member(timing, "sample_point"), 1, 100.0) + " %";
  line.push_back({rest});
  // Without it a controller that went bus-off stays so for ever.
  if (const Json& restart = member(controller, "restart_ms"); !restart.is_null())
    line.push_back({", restart-ms " + count(restart),
                    number_of(restart) == 0 ? Style::warning : Style::plain});
  return line;
}

}  // namespace

Lines source_section(const State& state, const Page& page) {
  const tools::Rates rates{*state.status, state.before};
  Table table{{header({"source", "state", "1/s", "age", "fused", "last"})}, {0, 1, 5}};
  const bool tested =
      page.columns >= with_innovations && tools::is_tested(member(*state.status, "sources"));
  if (tested) {
    table.rows[0].push_back({"NIS", Style::dim});
    table.rows[0].push_back({"in 95 %", Style::dim});
  }
  table.left.push_back(table.rows[0].size());
  table.rows[0].push_back({"not fused", Style::dim});
  for (const auto& source : member(*state.status, "sources")) {
    if (!is_true(member(source, "configured"))) continue;
    const Json& verdicts = member(source, "verdicts");
    const Json& earlier =
        tools::namesake(member(rates.before(), "sources"), member(source, "name"));
    const bool healthy = is_true(member(source, "healthy"));
    std::string last = word(member(source, "last_verdict"));
    const bool fine = last == "fused" || last == "source_off" || last == "none";
    if (const Json& ratio = member(source, "test_ratio"); !ratio.is_null())
      last += " " + tools::number(ratio, 2);
    const std::string refused = counts_in_words(verdicts, {"fused", "source_off"});
    const bool unused =
        number_of(member(verdicts, "source_off")) > 0 && number_of(member(verdicts, "fused")) == 0;
    table.rows.push_back({{word(member(source, "name"))},
                          {tools::source_state(source), healthy ? Style::good : Style::bad},
                          {rates.of(tools::sum(verdicts), tools::sum(member(earlier, "verdicts")))},
                          {duration(member(source, "age_s"))},
                          {count(member(verdicts, "fused")), unused ? Style::dim : Style::plain},
                          {unused ? "unused by the model" : last, unused ? Style::dim
                                                                  : fine ? Style::plain
                                                                         : Style::warning}});
    auto& row = table.rows.back();
    if (tested) {
      row.push_back({tools::nis_by_expectation(member(source, "innovations"))});
      row.push_back({tools::percent_inside(member(source, "innovations"))});
    }
    row.push_back({refused, Style::warning});
  }
  if (table.rows.size() == 1) return {};
  return under(title("sources", "", page), table);
}

Lines calibration_section(const State& state, const Page& page) {
  Table table{{}, {0, 2, 3}};
  for (const auto& [name, value, sigma, unit, valid] : tools::calibrations_of(*state.status))
    table.rows.push_back({{name},
                          {value, Style::strong},
                          {std::string{glyph(page, "± ", "+- ")} + sigma + unit},
                          {valid ? "learnt" : "not yet", valid ? Style::good : Style::dim}});
  if (table.rows.empty()) return {};
  return under(title("calibration", "", page), table);
}

Lines camera_section(const State& state, const Page& page) {
  const Json& camera = member(*state.status, "camera");
  if (!camera.is_object() || word(member(camera, "socket")).empty()) return {};
  const tools::Rates rates{*state.status, state.before};
  const Json& earlier = member(rates.before(), "camera");
  Lines lines{title("camera", word(member(camera, "socket")), page)};
  Line line{
      {"  " + rates.of(member(camera, "messages"), member(earlier, "messages")) + " poses/s"}};
  if (const Json& latency = member(camera, "last_latency_s"); !latency.is_null())
    line.push_back({", the last one " + duration(latency) + " late"});
  const auto connections = member(camera, "connections").size();
  line.push_back(
      {", " + std::to_string(connections) + (connections == 1 ? " connection" : " connections"),
       connections == 0 ? Style::warning : Style::plain});
  if (const std::uint64_t malformed = number_of(member(camera, "malformed")); malformed > 0)
    line.push_back({", " + std::to_string(malformed) + " malformed", Style::warning});
  lines.push_back(std::move(line));
  return lines;
}

Lines message_section(const State& state, const Page& page) {
  const tools::Rates rates{*state.status, state.before};
  Table table{{header({"message", "id", "1/s", "age", "decoded", "refused"})}, {0, 1, 5}};
  for (const auto& message : member(*state.status, "messages")) {
    const Json& verdicts = member(message, "verdicts");
    const Json& earlier =
        tools::namesake(member(rates.before(), "messages"), member(message, "name"));
    std::string refused = counts_in_words(verdicts, {"decoded", "unmapped"});
    if (const std::uint64_t some_lost = number_of(member(message, "some_lost")); some_lost > 0)
      refused += (refused.empty() ? "" : ", ") + std::to_string(some_lost) + " after a gap";
    table.rows.push_back({{word(member(message, "name"))},
                          {tools::hexadecimal(member(message, "id"))},
                          {rates.of(tools::sum(verdicts), tools::sum(member(earlier, "verdicts")))},
                          {duration(member(message, "age_s"))},
                          {count(member(verdicts, "decoded"))},
                          {refused, Style::warning}});
  }
  if (table.rows.size() == 1) return {};
  return under(title("messages", "", page), table);
}

Lines bus_section(const State& state, const Page& page) {
  const tools::Rates rates{*state.status, state.before};
  Lines lines{title("bus", "", page)};
  for (const auto& bus : member(*state.status, "can")) {
    const Json& earlier = tools::namesake(member(rates.before(), "can"), member(bus, "name"));
    const std::string link = word(member(bus, "link"));
    Line line{{"  " + word(member(bus, "name")) + ' ', Style::strong},
              {link, link == "up" ? Style::good : Style::bad},
              {", " + rates.of(member(bus, "received"), member(earlier, "received")) +
               " frames/s, " + count(member(bus, "received")) + " in all"}};
    constexpr std::array wrong{std::pair{"lost", " lost"},
                               std::pair{"error_frames", " error frames"},
                               std::pair{"malformed", " malformed lines"},
                               std::pair{"controller_overflows", " controller overflows"},
                               std::pair{"bus_offs", " times bus-off"},
                               std::pair{"link_downs", " times down"}};
    for (const auto& [key, name] : wrong)
      if (const std::uint64_t n = number_of(member(bus, key)); n > 0)
        line.push_back({", " + std::to_string(n) + name, Style::warning});
    lines.push_back(std::move(line));
    if (const Json& controller = member(bus, "controller"); controller.is_object())
      lines.push_back(controller_line(controller));
  }
  if (lines.size() == 1) return {};
  return lines;
}

}  // namespace odomd::watch
