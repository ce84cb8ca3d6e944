#include "tools/doctor/daemon.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <limits>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "daemon/core/source_diagnostics.hpp"
#include "tools/diagnostics/kinds.hpp"
#include "tools/live/status_values.hpp"
#include "tools/replay/source_checks.hpp"

namespace odomd::tools::doctor {
namespace {

using diagnostics::Diagnostics;
using diagnostics::found;
using diagnostics::Kind;
using tools::kind;

constexpr double settled_s = 3.0;              // after a start; every message has come by then
constexpr double silent_s = 2.0;               // no bus and no camera pauses that long
constexpr std::uint64_t enough_samples = 500;  // for their statistics

double value_of(const Json& value, double otherwise) {
  return value.is_null() ? otherwise : value.get<double>();
}

double number_of(const Json& object, const std::string& key, double otherwise = 0.0) {
  return value_of(member(object, key), otherwise);
}

template <typename Names>
std::optional<std::size_t> index_in(const Names& names, const std::string& name) {
  const auto at = std::ranges::find(names, name);
  if (at == names.end()) return std::nullopt;
  return static_cast<std::size_t>(at - names.begin());
}

// "odomd@can0" of a service's segment, "/run/odomd/can0/pose"; empty for one started by hand.
std::string service_of(const Json& status) {
  constexpr std::string_view folder = "/run/odomd/";
  const std::string segment = word(member(status, "shm"));
  const std::size_t end = segment.rfind('/');
  if (!segment.starts_with(folder) || end <= folder.size()) return {};
  return "odomd@" + segment.substr(folder.size(), end - folder.size());
}

void examine_version(const Json& status, Diagnostics& all) {
  const std::string version = word(member(status, "version"));
  if (version == ODOMD_VERSION) return;
  const std::string service = service_of(status);
  all.push_back(found(kind("other_version"), "odomd",
                      fmt::format("is of version {}, odom of {}", version, ODOMD_VERSION),
                      service.empty() ? "odomd@can0" : service));
}

void examine_grants(const Json& status, const Machine& machine, Diagnostics& all) {
  const Json& granted = member(status, "realtime");
  if (!granted.is_object()) return;
  if (number_of(granted, "priority") == 0.0)
    all.push_back(found(kind("no_realtime_priority"), "odomd",
                        "its beat has no real-time priority, so other programs delay the poses",
                        fmt::format("{} - rtprio 99", machine.user)));
  if (!is_true(member(granted, "memory_locked")))
    all.push_back(found(kind("memory_not_locked"), "odomd",
                        "its memory is not locked, so a tick may wait for the disk", machine.user));
  constexpr const Kind& sleep = kind("cpus_sleep_deeply");
  if (!is_true(member(granted, "dma_latency_held")) && !sleep.limits.hold(machine.deepest_sleep_us))
    all.push_back(
        found(sleep, "odomd",
              fmt::format("may not open /dev/cpu_dma_latency: CPUs wake {:.0f} µs late from their "
                          "deepest sleep",
                          machine.deepest_sleep_us),
              service_of(status).empty() ? machine.group : "odomd"));
  for (const Json& refusal : member(granted, "refusals"))
    if (refusal.get<std::string>().find("is not pinned") != std::string::npos)
      all.push_back(found(kind("cpu_not_pinned"), "odomd", refusal.get<std::string>()));
}

void examine_beat(const Json& status, Diagnostics& all) {
  const Json& beat = member(status, "beat");
  if (!beat.is_object()) return;
  constexpr double us = 1e-6;
  const double works_s = us * number_of(member(beat, "execution_us"), "p999");
  const double period_s = number_of(beat, "period_s", 1.0);
  constexpr const Kind& long_ticks = kind("ticks_too_long");
  if (!long_ticks.limits.hold(works_s / period_s)) {
    all.push_back(found(long_ticks, "odomd",
                        fmt::format("a tick works for up to {:.1f} ms, its period is {:.1f} ms",
                                    1e3 * works_s, 1e3 * period_s)));
    return;
  }
  // An ordinary thread misses cycles on any machine.
  if (number_of(member(status, "realtime"), "priority") == 0.0) return;
  const double missed = number_of(beat, "missed");
  const double cycles = std::max(missed + number_of(beat, "ticks"), 1.0);
  constexpr const Kind& late = kind("beat_wakes_late");
  if (late.limits.hold(missed / cycles)) return;
  all.push_back(
      found(late, "odomd",
            fmt::format("missed {:.0f} of {:.0f} cycles; it woke up to {:.1f} ms late", missed,
                        cycles, 1e-3 * number_of(member(beat, "wakeup_us"), "max"))));
}

enum class Traffic { none, comes, ended };

// What is wrong with the buses' traffic as a whole, and whether there is any.
Traffic examine_buses(const Json& status, Diagnostics& all) {
  Traffic traffic = Traffic::none;
  bool ended = false;
  const double uptime_s = number_of(status, "uptime_s");
  for (const Json& bus : member(status, "can")) {
    const std::string name = word(member(bus, "name"));
    const std::string link = word(member(bus, "link"));
    ended |= link == "ended";
    const double received = number_of(bus, "received");
    if (link == "up" && received > 0.0) traffic = Traffic::comes;
    if (link == "up" && received == 0.0 && uptime_s > settled_s)
      all.push_back(found(kind("no_frames"), name,
                          fmt::format("no frame came since odomd started {:.0f} s ago", uptime_s)));
    const auto examine_losses = [&](const Kind& lost, const std::string& key) {
      const double count = number_of(bus, key);
      if (!lost.limits.hold(count / std::max(count + received, 1.0)))
        all.push_back(found(
            lost, name, fmt::format("{:.0f} frames are lost, {:.0f} arrived", count, received)));
    };
    examine_losses(kind("frames_lost"), "lost");
    examine_losses(kind("controller_overflows"), "controller_overflows");
  }
  if (ended) return Traffic::ended;
  // Frames came once; the newest mapped one says until when.
  double youngest_s = std::numeric_limits<double>::infinity();
  for (const Json& message : member(status, "messages"))
    youngest_s =
        std::min(youngest_s, number_of(message, "age_s", std::numeric_limits<double>::infinity()));
  if (traffic != Traffic::comes || !std::isfinite(youngest_s) || youngest_s < silent_s)
    return traffic;
  all.push_back(found(kind("no_frames"), "odomd",
                      fmt::format("the last mapped frame came {:.0f} s ago", youngest_s)));
  return Traffic::none;
}

void examine_messages(const Json& status, Diagnostics& all) {
  for (const Json& message : member(status, "messages")) {
    const std::string name = fmt::format("message '{}'", word(member(message, "name")));
    const Json& verdicts = member(message, "verdicts");
    if (verdicts.is_null()) continue;
    if (sum(verdicts) == 0)
      all.push_back(found(kind("message_missing"), name, "was never received"));
    else if (number_of(verdicts, "decoded") == 0.0)
      all.push_back(found(kind("message_without_value"), name,
                          fmt::format("none of its {} frames gave a value", sum(verdicts))));
  }
}

// Mistakes in wiring and description, one for all its sources. Returns whether there is one.
bool examine_wiring(const Json& status, Diagnostics& all) {
  bool any = false;
  for (std::size_t fault = 1; fault < daemon::wiring_names.size(); ++fault) {
    std::vector<std::string> sources;
    for (const Json& source : member(status, "sources"))
      if (word(member(source, "wiring")) == daemon::wiring_names[fault])
        sources.push_back(word(member(source, "name")));
    if (sources.empty()) continue;
    append(all, daemon::diagnostic_of(static_cast<daemon::WiringFault>(fault), sources.front(),
                                      fmt::format("{}", fmt::join(sources, ", "))));
    any = true;
  }
  return any;
}

std::optional<diagnostics::Diagnostic> check_statistics(const Json& source,
                                                        const std::string& name) {
  const Json& innovations = member(source, "innovations");
  const double dimension = number_of(innovations, "dimension");
  const auto index = index_in(estimator::source_names, name);
  if (dimension == 0.0 || !index ||
      number_of(innovations, "count") < static_cast<double>(enough_samples))
    return std::nullopt;
  constexpr const Kind& gated = kind("often_gated");
  const double share = number_of(innovations, "gated") / number_of(innovations, "count");
  if (!gated.limits.hold(share))
    return found(gated, name,
                 fmt::format("{:.0f} % of its samples were gated, too far from what the filter "
                             "expected by the others",
                             100.0 * share),
                 std::string{what_to_check(static_cast<estimator::Source>(*index))});
  constexpr const Kind& sigma = kind("sigma_off");
  const double ratio = number_of(innovations, "mean_nis", dimension) / dimension;
  if (sigma.limits.hold(ratio)) return std::nullopt;
  const bool is_camera = name == "camera";
  return found(
      sigma, name,
      fmt::format("its samples scatter {:.2g} times as much as their sigma says", std::sqrt(ratio)),
      fmt::format("{} by {:.2g}",
                  is_camera ? std::string{"the sigmas that the camera sends"}
                            : fmt::format("can.signals.{}.sigma", name),
                  std::sqrt(ratio)));
}

bool is_overdue(const Json& source) {
  const std::string flag = word(member(source, "flag"));
  const double age_s = number_of(source, "age_s", -1.0);
  return !is_true(member(source, "healthy")) && (flag == "ok" || flag == "timed_out") &&
         age_s > number_of(source, "timeout_s", age_s);
}

void examine_sources(const Json& status, Diagnostics& all) {
  const bool miswired = examine_wiring(status, all);
  std::vector<std::string> overdue;
  double age_s = 0.0;
  for (const Json& source : member(status, "sources")) {
    if (!is_true(member(source, "configured"))) continue;
    const std::string name = word(member(source, "name"));
    const auto flag = static_cast<estimator::SourceFlag>(
        index_in(estimator::source_flag_names, word(member(source, "flag"))).value_or(0));
    const bool contradicts = flag == estimator::SourceFlag::drifting;
    if (!(miswired && contradicts)) append(all, daemon::diagnostic_of(flag, name));
    if (is_overdue(source)) {
      overdue.push_back(name);
      age_s = std::max(age_s, number_of(source, "age_s"));
    }
    if (miswired || flag != estimator::SourceFlag::ok) continue;
    if (is_true(member(source, "inconsistent")))
      all.push_back(daemon::inconsistent_source(name));
    else
      append(all, check_statistics(source, name));
  }
  if (overdue.empty()) return;
  const Json& buses = member(status, "can");
  all.push_back(found(kind("signal_overdue"), fmt::format("{}", fmt::join(overdue, ", ")),
                      fmt::format("last came {:.3g} s ago", age_s),
                      buses.empty() ? "can0" : word(member(buses.front(), "name"))));
}

void examine_camera(const Json& status, Diagnostics& all) {
  const Json& camera = member(status, "camera");
  if (!camera.is_object() || word(member(camera, "socket")).empty()) return;
  const double malformed = number_of(camera, "malformed");
  if (malformed > 0.0)
    all.push_back(found(kind("camera_messages_malformed"), "camera",
                        fmt::format("{:.0f} messages were not camera poses", malformed)));
  const Json& source = namesake(member(status, "sources"), "camera");
  const double age_s = number_of(source, "age_s", number_of(status, "uptime_s"));
  if (age_s > silent_s && malformed == 0.0)
    all.push_back(found(kind("camera_silent"), "camera",
                        fmt::format("no pose came for {:.0f} s{}", age_s,
                                    word(member(status, "mode")) == "initialising"
                                        ? "; odomd waits for the first one"
                                        : "")));
  const Json& verdicts = member(source, "verdicts");
  if (verdicts.is_null()) return;
  const double unusable = number_of(verdicts, "too_old") + number_of(verdicts, "future");
  constexpr const Kind& times = kind("camera_times");
  if (!times.limits.hold(unusable / std::max(static_cast<double>(sum(verdicts)), 1.0)))
    all.push_back(found(times, "camera",
                        fmt::format("{:.0f} of its {} poses were too old or from the future",
                                    unusable, sum(verdicts))));
}

}  // namespace

Diagnostics examine_daemon(const Json& status, const Machine& machine) {
  Diagnostics all;
  examine_version(status, all);
  examine_grants(status, machine, all);
  examine_beat(status, all);
  const Traffic traffic = examine_buses(status, all);
  for (const Json& condition : member(status, "conditions")) {
    if (condition == "model_fault")
      all.push_back(found(kind("model_fault"), "odomd", "its model stopped"));
    if (condition == "camera_refused")
      all.push_back(found(kind("camera_refused"), "camera",
                          "a connection was refused within the last ten seconds"));
    if (condition == "bias_unlearnt") all.push_back(daemon::unlearnt_bias());
    if (condition == "scale_implausible") all.push_back(daemon::implausible_scale());
  }
  if (traffic == Traffic::comes && number_of(status, "uptime_s") > settled_s) {
    examine_messages(status, all);
    examine_sources(status, all);
  }
  if (traffic != Traffic::ended) examine_camera(status, all);
  return all;
}

}  // namespace odomd::tools::doctor
