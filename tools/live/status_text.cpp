#include "tools/live/status_text.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <sstream>
#include <tuple>
#include <utility>

#include "tools/cli/csv.hpp"
#include "tools/cli/text.hpp"
#include "tools/diagnostics/conditions.hpp"
#include "tools/drive_files/pose_csv.hpp"
#include "tools/live/status_table.hpp"

namespace odomd::tools {
namespace {

// The label in front of the first line, blanks in front of the others.
std::string labelled(std::string label, const std::string& text) {
  std::string all;
  std::istringstream lines{text};
  for (std::string line; std::getline(lines, line); label.clear())
    all += fmt::format("{:<12}{}\n", label, line);
  return all;
}

// The lines below a blank line.
std::string paragraph(const Lines& lines) {
  std::string text;
  for (const Line& line : lines) text += (text.empty() ? "\n" : "") + as_text(line) + '\n';
  return text;
}

std::string head(const StatusValue& now) {
  return fmt::format("odomd {}, pid {}, up {}, model {}\nconfiguration {}, segment {}\n\n",
                     now["version"].text(), now["pid"].text(), now["uptime_s"].duration(),
                     now["model"].text(), now["config"].text(), now["shm"].text());
}

std::string conditions(const StatusValue& now) {
  std::string text;
  for (const StatusValue& name : now["conditions"].elements()) {
    const auto condition = condition_named(name.text());
    text += name.text() + (condition ? fmt::format(": {}\n", condition->meaning) : "\n");
  }
  return text;
}

std::string pose(const StatusValue& pose) {
  if (!pose.exists()) return labelled("pose", "none published yet");
  const auto with_sigma = [&](const char* key, const char* sigma) {
    return fmt::format("{} ± {}", pose[key].number(3), pose[sigma].number(3));
  };
  return labelled("pose",
                  fmt::format("x {} m,  y {} m,  yaw {} ± {} deg", with_sigma("x", "sigma_x"),
                              with_sigma("y", "sigma_y"),
                              pose["yaw"].exists() ? fixed(heading(pose["yaw"].value()), 2) : "-",
                              pose["sigma_yaw"].number(2, degrees))) +
         labelled("motion",
                  fmt::format("{} m/s forward,  {} m/s to the left,  {} deg/s,  steering {} deg\n"
                              "tick {}, {} old, {}",
                              pose["vx"].number(3), pose["vy"].number(3),
                              pose["yaw_rate"].number(2, degrees),
                              pose["steering"].number(2, degrees), pose["tick"].text(),
                              pose["age_s"].duration(), pose["reset_count"].counted("reset")));
}

std::string beat(const StatusValue& beat) {
  if (!beat.exists()) return {};
  std::string text =
      fmt::format("{} Hz, {}, {} missed, {}, {} carried over\n", beat["ticks"].rate(),
                  beat["ticks"].counted("tick"), beat["missed"].text(),
                  beat["overruns"].counted("overrun"), beat["carried_over"].text());
  if (beat["last_overrun_age_s"].exists())
    text += fmt::format("last overrun {} ago: that tick worked for {} us\n",
                        beat["last_overrun_age_s"].duration(),
                        beat["last_overrun_execution_us"].number(0));
  Table table{{"[us]", "median", "99 %", "99.9 %", "max"}, {}, {0}};
  for (const auto& [key, label] :
       {std::pair{"wakeup_us", "wake-up late by"}, std::pair{"execution_us", "a tick works for"}}) {
    const StatusValue times = beat[key];
    if (!times.exists()) continue;
    table.rows.push_back({label, times["p50"].number(1), times["p99"].number(1),
                          times["p999"].number(1), times["max"].number(1)});
  }
  return labelled("beat", text + table.text());
}

std::string realtime(const StatusValue& realtime) {
  if (!realtime.exists()) return {};
  const double priority = realtime["priority"].value();
  std::string text = fmt::format(
      "{}, {}, {}\n", priority > 0.0 ? fmt::format("SCHED_FIFO {}", priority) : "not scheduled",
      realtime["memory_locked"].is_true() ? "memory locked" : "memory not locked",
      realtime["dma_latency_held"].is_true() ? "cpu_dma_latency held" : "cpu_dma_latency not held");
  for (const StatusValue& refusal : realtime["refusals"].elements())
    text += fmt::format("refused: {}\n", refusal.text());
  return labelled("real time", text);
}

std::string buses(const std::vector<StatusValue>& buses) {
  return paragraph(
      table_of({left(column("bus", "name")), left(column("link", "link")),
                column("frames", "received"), column("1/s", "received", &StatusValue::rate),
                column("lost", "lost"), column("errors", "error_frames"),
                column("malformed", "malformed"), column("downs", "link_downs")},
               buses));
}

// The counts of frame problems that are not 0.
std::string bus_remarks(const std::vector<StatusValue>& buses) {
  std::string text;
  for (const StatusValue& bus : buses) {
    std::string remarks;
    for (const auto& [key, remark] :
         {std::pair{"bus_offs", "error frames reported bus-off"},
          std::pair{"controller_overflows",
                    "error frames reported that the controller lost frames"},
          std::pair{"stamp_fallbacks", "frames stamped when read"},
          std::pair{"hardware_fallbacks", "frames without a hardware stamp"}})
      if (const std::uint64_t count = bus[key].count(); count > 0)
        remarks += fmt::format("{} {} {}", remarks.empty() ? ":" : ",", count, remark);
    if (!remarks.empty()) text += bus["name"].text() + remarks + '\n';
  }
  return text;
}

// The controllers, of the buses that have one.
std::string controllers(std::vector<StatusValue> buses) {
  std::erase_if(buses, [](const StatusValue& bus) { return !bus["controller"].exists(); });
  const auto state = [](const StatusValue& bus) {
    std::string text = hyphenated(bus["controller/state"].text());
    for (const StatusValue& mode : bus["controller/modes"].elements()) text += ", " + mode.text();
    return Span{text};
  };
  const auto sample_point = [](const StatusValue& bus) {
    return Span{bus["controller/bit_timing/sample_point"].number(3)};
  };
  const auto restart = [](const StatusValue& bus) {
    const StatusValue ms = bus["controller/restart_ms"];
    return Span{ms.exists() && ms.count() == 0 ? "never" : ms.text() + (ms.exists() ? " ms" : "")};
  };
  return paragraph(table_of({left(column("controller", "name")),
                             {"state", state, true},
                             column("errors tx", "controller/tx_errors"),
                             column("rx", "controller/rx_errors"),
                             column("bit/s", "controller/bit_timing/bitrate"),
                             {"sample point", sample_point},
                             {"restart", restart},
                             column("bus errors", "controller/bus_errors"),
                             column("passive", "controller/error_passives"),
                             column("bus-off", "controller/bus_offs"),
                             column("restarts", "controller/restarts")},
                            buses));
}

// The sigmas of the sources' samples, if the model estimates them.
std::string noise(const StatusValue& now) {
  std::vector<StatusValue> sources = now["sources"].elements();
  std::erase_if(sources, [](const StatusValue& source) {
    const StatusValue noise = source["noise"];
    return !noise["at_rest"].exists() && !noise["moving"].exists() &&
           !noise["speed_share"].exists();
  });
  const auto unit = [](const StatusValue& source) {
    const std::string name = source["name"].text();
    return Span{name == "yaw_rate" ? "rad/s" : name.starts_with("accel") ? "m/s2" : "m/s"};
  };
  const auto share = [](const StatusValue& source) {
    const StatusValue part = source["noise/speed_share"];
    return Span{part.number(2, 100.0) + (part.exists() ? " %" : "")};
  };
  constexpr auto significant = &StatusValue::significant;
  return paragraph(table_of({left(column("noise", "name")),
                             {"unit", unit, true},
                             column("stated", "sigma", significant),
                             column("at rest", "noise/at_rest", significant),
                             column("moving", "noise/moving", significant),
                             {"of speed", share}},
                            sources));
}

std::string camera(const StatusValue& camera) {
  if (!camera.exists() || camera["socket"].text().empty()) return {};
  const auto received = [](const std::string& from, const StatusValue& here) {
    return fmt::format("{}: {}, {} malformed\n", from, here["messages"].counted("message"),
                       here["malformed"].text());
  };
  std::string text = received(camera["socket"].text(), camera);
  for (const StatusValue& connection : camera["connections"].elements())
    text += received("pid " + connection["pid"].text(), connection);
  return '\n' + labelled("camera", text);
}

std::string clock(const StatusValue& clock) {
  if (!clock.exists()) return {};
  return labelled("clock", fmt::format("{} of the wall clock, {}", clock["steps"].counted("step"),
                                       clock["suspends"].counted("suspend")));
}

// Sigma of x, y or yaw, given its index on the covariance's diagonal.
double sigma_of(const odom_pose& pose, std::size_t diagonal) {
  return std::sqrt(std::max(0.0, pose.covariance[diagonal]));
}

}  // namespace

std::string pose_as_text(const odom_pose& pose, std::int64_t age_ns) {
  std::string text = "mode   " + mode_name(pose.mode) + '\n';
  for (const Condition& condition : conditions_in(pose.conditions))
    text += fmt::format("       {}: {}\n", condition.name, condition.meaning);
  for (const auto& [name, value, unit, decimals, deviation] :
       {std::tuple{"x", pose.x, "m", 4, sigma_of(pose, 0)},
        {"y", pose.y, "m", 4, sigma_of(pose, 3)},
        {"yaw", heading(pose.yaw), "deg", 3, degrees * sigma_of(pose, 5)}})
    text += fmt::format("{:<6}{:>12} {:<3}  ± {}\n", name, fixed(value, decimals), unit,
                        fixed(deviation, decimals));
  return text + fmt::format(
                    "speed {:>12} m/s forward, {} m/s to the left, {} deg/s\n"
                    "tick  {:>12}, {} ms old, {}\n",
                    fixed(pose.vx, 4), fixed(pose.vy, 4), fixed(degrees * pose.yaw_rate, 2),
                    pose.tick, fixed(1e-6 * static_cast<double>(age_ns), 1),
                    counted(pose.reset_count, "reset"));
}

std::string pose_as_json(const odom_pose& pose, std::int64_t age_ns, const std::string& clock,
                         std::int64_t t_ns, bool fresh) {
  nlohmann::ordered_json conditions = nlohmann::ordered_json::array();
  for (const Condition& condition : conditions_in(pose.conditions)) {
    conditions.push_back(condition.name);
  }
  const nlohmann::ordered_json json{{"fresh", fresh},
                                    {"tick", pose.tick},
                                    {"clock", clock},
                                    {"time_ns", t_ns},
                                    {"age_s", static_cast<double>(age_ns) / 1e9},
                                    {"mode", mode_name(pose.mode)},
                                    {"conditions", conditions},
                                    {"x", pose.x},
                                    {"y", pose.y},
                                    {"yaw", pose.yaw},
                                    {"sigma_x", sigma_of(pose, 0)},
                                    {"sigma_y", sigma_of(pose, 3)},
                                    {"sigma_yaw", sigma_of(pose, 5)},
                                    {"odom_x", pose.odom_x},
                                    {"odom_y", pose.odom_y},
                                    {"odom_yaw", pose.odom_yaw},
                                    {"vx", pose.vx},
                                    {"vy", pose.vy},
                                    {"yaw_rate", pose.yaw_rate},
                                    {"steering", pose.steering},
                                    {"accel_x", pose.accel_x},
                                    {"accel_y", pose.accel_y},
                                    {"reset_count", pose.reset_count},
                                    {"last_jump", {pose.jump_x, pose.jump_y, pose.jump_yaw}}};
  return json.dump(2) + '\n';
}

std::string pose_as_line(const odom_pose& pose, std::int64_t t_ns) {
  std::string time;
  append_seconds(time, t_ns);
  return fmt::format("{:>20}  x {:>9}  y {:>9}  yaw {:>7} deg  v {:>6} m/s  {}\n", time,
                     fixed(pose.x, 3), fixed(pose.y, 3), fixed(heading(pose.yaw), 1),
                     fixed(pose.vx, 2), mode_name(pose.mode));
}

std::string status_as_text(const Json& document, const std::optional<Json>& before) {
  const StatusValue now{document, before};
  const auto can = now["can"].elements();
  return head(now) + labelled("mode", now["mode"].text()) +
         labelled("conditions", conditions(now)) + pose(now["pose"]) + '\n' + beat(now["beat"]) +
         realtime(now["realtime"]) + buses(can) + bus_remarks(can) + controllers(can) +
         paragraph(message_table(now, Form::whole)) + paragraph(source_table(now, Form::whole)) +
         noise(now) + paragraph(calibration_table(now, Form::whole, Glyphs::unicode)) +
         camera(now["camera"]) + clock(now["clock"]);
}

}  // namespace odomd::tools
