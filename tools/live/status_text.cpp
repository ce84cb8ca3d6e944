#include "tools/live/status_text.hpp"

#include <algorithm>
#include <cmath>

#include "can_protocol/decode/decoder.hpp"
#include "tools/cli/text.hpp"
#include "tools/diagnostics/conditions.hpp"
#include "tools/live/status_values.hpp"

namespace odomd::tools {
namespace {

std::string head(const Json& now) {
  return "odomd " + word(member(now, "version")) + ", pid " + count(member(now, "pid")) + ", up " +
         duration(member(now, "uptime_s")) + ", model " + word(member(now, "model")) +
         "\nconfiguration " + word(member(now, "config")) + ", segment " +
         word(member(now, "shm")) + "\n\n";
}

std::string mode(const Json& now) {
  std::string text = "mode        " + word(member(now, "mode")) + '\n';
  std::string label = "conditions  ";
  for (const auto& name : member(now, "conditions")) {
    const auto condition = condition_named(name.get<std::string>());
    text += label + name.get<std::string>();
    if (condition) text += ": " + std::string{condition->meaning};
    text += '\n';
    label.assign(label.size(), ' ');
  }
  return text;
}

// Without the whole turns that the daemon counts.
std::string heading(const Json& yaw) {
  return yaw.is_null() ? "-" : fixed(degrees * std::remainder(yaw.get<double>(), full_turn), 2);
}

std::string pose(const Json& pose) {
  if (!pose.is_object()) return "pose        none published yet\n";
  const auto with_sigma = [&](const char* key, const char* sigma) {
    return number(member(pose, key), 3) + " ± " + number(member(pose, sigma), 3);
  };
  return "pose        x " + with_sigma("x", "sigma_x") + " m,  y " + with_sigma("y", "sigma_y") +
         " m,  yaw " + heading(member(pose, "yaw")) + " ± " +
         number(member(pose, "sigma_yaw"), 2, degrees) + " deg\nmotion      " +
         number(member(pose, "vx"), 3) + " m/s forward,  " + number(member(pose, "vy"), 3) +
         " m/s to the left,  " + number(member(pose, "yaw_rate"), 2, degrees) +
         " deg/s,  steering " + number(member(pose, "steering"), 2, degrees) +
         " deg\n            tick " + count(member(pose, "tick")) + ", " +
         duration(member(pose, "age_s")) + " old, " +
         counted(member(pose, "reset_count"), "reset") + '\n';
}

std::string beat(const Json& beat, const Rates& rates) {
  if (!beat.is_object()) return {};
  std::string text =
      "beat        " +
      rates.of(member(beat, "ticks"), member(member(rates.before(), "beat"), "ticks")) + " Hz, " +
      counted(member(beat, "ticks"), "tick") + ", " + count(member(beat, "missed")) + " missed, " +
      counted(member(beat, "overruns"), "overrun") + ", " + count(member(beat, "carried_over")) +
      " carried over\n";
  if (!member(beat, "last_overrun_age_s").is_null()) {
    text += "            last overrun " + duration(member(beat, "last_overrun_age_s")) +
            " ago: that tick worked for " + number(member(beat, "last_overrun_execution_us"), 0) +
            " us\n";
  }
  Table table{{"            [us]", "median", "99 %", "99.9 %", "max"}, {}, {0}};
  for (const auto& [key, label] : {std::pair{"wakeup_us", "            wake-up late by"},
                                   std::pair{"execution_us", "            a tick works for"}}) {
    const Json& times = member(beat, key);
    if (!times.is_object()) continue;
    table.rows.push_back({label, number(member(times, "p50"), 1), number(member(times, "p99"), 1),
                          number(member(times, "p999"), 1), number(member(times, "max"), 1)});
  }
  return text + table.text();
}

std::string realtime(const Json& realtime) {
  if (!realtime.is_object()) return {};
  const auto yes = [&](const char* key) { return is_true(member(realtime, key)); };
  const Json& priority = member(realtime, "priority");
  const bool fifo = !priority.is_null() && priority.get<int>() > 0;
  std::string text = "real time   ";
  text += fifo ? "SCHED_FIFO " + std::to_string(priority.get<int>()) : std::string{"not scheduled"};
  text += yes("memory_locked") ? ", memory locked" : ", memory not locked";
  text += yes("dma_latency_held") ? ", cpu_dma_latency held\n" : ", cpu_dma_latency not held\n";
  for (const auto& refusal : member(realtime, "refusals")) {
    text += "            refused: " + refusal.get<std::string>() + '\n';
  }
  return text;
}

std::string buses(const Json& now, const Rates& rates) {
  Table table{{"bus", "link", "frames", "1/s", "lost", "errors", "malformed", "downs"}, {}, {0, 1}};
  for (const auto& bus : member(now, "can")) {
    const Json& earlier = namesake(member(rates.before(), "can"), member(bus, "name"));
    table.rows.push_back({word(member(bus, "name")), word(member(bus, "link")),
                          count(member(bus, "received")),
                          rates.of(member(bus, "received"), member(earlier, "received")),
                          count(member(bus, "lost")), count(member(bus, "error_frames")),
                          count(member(bus, "malformed")), count(member(bus, "link_downs"))});
  }
  return table.rows.empty() ? std::string{} : '\n' + table.text();
}

// Counts of frame problems that are not 0.
std::string bus_remarks(const Json& now) {
  std::string text;
  for (const auto& bus : member(now, "can")) {
    std::string remarks;
    for (const auto& [key, remark] :
         {std::pair{"bus_offs", "error frames reported bus-off"},
          std::pair{"controller_overflows",
                    "error frames reported that the controller lost frames"},
          std::pair{"stamp_fallbacks", "frames stamped when read"},
          std::pair{"hardware_fallbacks", "frames without a hardware stamp"}}) {
      const Json& value = member(bus, key);
      if (value.is_null() || value.get<std::uint64_t>() == 0) continue;
      remarks += (remarks.empty() ? "" : ", ") + count(value) + ' ' + remark;
    }
    if (!remarks.empty()) text += word(member(bus, "name")) + ": " + remarks + '\n';
  }
  return text;
}

std::string restart(const Json& restart_ms) {
  if (restart_ms.is_null()) return "-";
  const auto ms = restart_ms.get<std::uint64_t>();
  return ms == 0 ? "never" : std::to_string(ms) + " ms";
}

// Below the buses that have one.
std::string controllers(const Json& now) {
  Table table{{"controller", "state", "errors tx", "rx", "bit/s", "sample point", "restart",
               "bus errors", "passive", "bus-off", "restarts"},
              {},
              {0, 1}};
  for (const auto& bus : member(now, "can")) {
    const Json& controller = member(bus, "controller");
    if (!controller.is_object()) continue;
    const Json& timing = member(controller, "bit_timing");
    const bool timed = timing.is_object();
    std::string state = word(member(controller, "state"));
    std::ranges::replace(state, '_', '-');
    for (const auto& mode : member(controller, "modes")) state += ", " + mode.get<std::string>();
    table.rows.push_back(
        {word(member(bus, "name")), state, count(member(controller, "tx_errors")),
         count(member(controller, "rx_errors")), timed ? count(member(timing, "bitrate")) : "-",
         timed ? number(member(timing, "sample_point"), 3) : "-",
         restart(member(controller, "restart_ms")), count(member(controller, "bus_errors")),
         count(member(controller, "error_passives")), count(member(controller, "bus_offs")),
         count(member(controller, "restarts"))});
  }
  return table.rows.empty() ? std::string{} : '\n' + table.text();
}

// Messages that are on the bus, and what was wrong with some.
std::string messages(const Json& now) {
  Table table{{"message", "id", "age", "decoded", "failed"}, {}, {0, 1, 4}};
  for (const auto& message : member(now, "messages")) {
    const Json& verdicts = member(message, "verdicts");
    std::string failed;
    for (const auto verdict :
         {can::FrameVerdict::too_short, can::FrameVerdict::failed_crc, can::FrameVerdict::repeated,
          can::FrameVerdict::wrong_sequence, can::FrameVerdict::distrusted}) {
      const std::string name{can::name_of(verdict)};
      const Json& value = member(verdicts, name);
      if (value.is_null() || value.get<std::uint64_t>() == 0) continue;
      failed += (failed.empty() ? "" : ", ") + count(value) + ' ' + name;
    }
    table.rows.push_back({word(member(message, "name")), hexadecimal(member(message, "id")),
                          duration(member(message, "age_s")), count(member(verdicts, "decoded")),
                          failed.empty() ? "0" : failed});
  }
  return table.rows.empty() ? std::string{} : '\n' + table.text();
}

std::string sources(const Json& now, const Rates& rates) {
  Table table{{"source", "state", "age", "1/s", "fused", "not fused", "last"}, {}, {0, 1, 5, 6}};
  const bool tested = is_tested(member(now, "sources"));
  if (tested) table.header.insert(table.header.end(), {"innovation", "NIS", "in 95 %"});
  for (const auto& source : member(now, "sources")) {
    const Json& configured = member(source, "configured");
    if (configured.is_null() || !configured.get<bool>()) continue;
    const Json& verdicts = member(source, "verdicts");
    const Json& earlier = namesake(member(rates.before(), "sources"), member(source, "name"));
    std::string refused;
    for (const auto& [verdict, value] : verdicts.items()) {
      if (verdict == "fused" || value.get<std::uint64_t>() == 0) continue;
      refused += (refused.empty() ? "" : ", ") + count(value) + ' ' + verdict;
    }
    std::string last = word(member(source, "last_verdict"));
    if (!member(source, "test_ratio").is_null()) {
      last += " (test ratio " + number(member(source, "test_ratio"), 2) + ")";
    }
    table.rows.push_back({word(member(source, "name")), source_state(source),
                          duration(member(source, "age_s")),
                          rates.of(sum(verdicts), sum(member(earlier, "verdicts"))),
                          count(member(verdicts, "fused")), refused.empty() ? "0" : refused, last});
    if (!tested) continue;
    std::string innovation;
    for (const auto& component : member(source, "innovation"))
      innovation += (innovation.empty() ? "" : " ") + number(component, 4);
    auto& row = table.rows.back();
    row.push_back(innovation.empty() ? "-" : innovation);
    row.push_back(nis_by_expectation(member(source, "innovations")));
    row.push_back(percent_inside(member(source, "innovations")));
  }
  return table.rows.empty() ? std::string{} : '\n' + table.text();
}

std::string unit_of(const std::string& source) {
  if (source == "yaw_rate") return "rad/s";
  return source.starts_with("accel") ? "m/s2" : "m/s";
}

// The sigmas of the sources' samples, where the model estimates them.
std::string noise(const Json& now) {
  Table table{{"noise", "unit", "stated", "at rest", "moving", "of speed"}, {}, {0, 1}};
  for (const auto& source : member(now, "sources")) {
    const Json& noise = member(source, "noise");
    const Json& at_rest = member(noise, "at_rest");
    const Json& moving = member(noise, "moving");
    const Json& share = member(noise, "speed_share");
    if (at_rest.is_null() && moving.is_null() && share.is_null()) continue;
    const std::string name = word(member(source, "name"));
    table.rows.push_back({name, unit_of(name), significant(member(source, "sigma")),
                          significant(at_rest), significant(moving),
                          share.is_null() ? "-" : number(share, 2, 100.0) + " %"});
  }
  return table.rows.empty() ? std::string{} : '\n' + table.text();
}

// The calibrations, if the model estimates them.
std::string calibrations(const Json& now) {
  Table table{{"calibration", "value", "", "learnt"}, {}, {0, 2, 3}};
  for (const auto& [name, value, sigma, unit, valid] : calibrations_of(now)) {
    table.rows.push_back({name, value, "± ", valid ? "yes" : "not yet"});
    table.rows.back()[2].append(sigma).append(unit);
  }
  return table.rows.empty() ? std::string{} : '\n' + table.text();
}

std::string camera(const Json& camera) {
  if (!camera.is_object() || word(member(camera, "socket")).empty()) return {};
  std::string text = "\ncamera      " + word(member(camera, "socket")) + ": " +
                     counted(member(camera, "messages"), "message") + ", " +
                     count(member(camera, "malformed")) + " malformed\n";
  for (const auto& connection : member(camera, "connections")) {
    text += "            pid " + count(member(connection, "pid")) + ": " +
            counted(member(connection, "messages"), "message") + ", " +
            count(member(connection, "malformed")) + " malformed\n";
  }
  return text;
}

std::string clock(const Json& clock) {
  if (!clock.is_object()) return {};
  return "clock       " + counted(member(clock, "steps"), "step") + " of the wall clock, " +
         counted(member(clock, "suspends"), "suspend") + '\n';
}

}  // namespace

std::string status_as_text(const Json& now, const std::optional<Json>& before) {
  const Rates rates{now, before};
  return head(now) + mode(now) + pose(member(now, "pose")) + '\n' +
         beat(member(now, "beat"), rates) + realtime(member(now, "realtime")) + buses(now, rates) +
         bus_remarks(now) + controllers(now) + messages(now) + sources(now, rates) + noise(now) +
         calibrations(now) + camera(member(now, "camera")) + clock(member(now, "clock"));
}

}  // namespace odomd::tools
