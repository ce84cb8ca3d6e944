#include "tools/doctor/doctor.hpp"

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
#include <vector>

#include "daemon/core/source_diagnostics.hpp"
#include "tools/diagnostics/kinds.hpp"
#include "tools/live/status_value.hpp"
#include "tools/replay/replay_checks.hpp"

namespace odomd::tools::doctor {
namespace {

using diagnostics::Diagnostics;
using diagnostics::found;
using diagnostics::Kind;
using tools::kind;

constexpr double settled_s = 3.0;           // uptime after which every message has arrived
constexpr double silent_s = 2.0;            // longer than any pause of a bus or a camera
constexpr std::uint64_t min_samples = 500;  // needed to judge a source's innovations

template <typename Names>
std::optional<std::size_t> index_in(const Names& names, const std::string& name) {
  const auto at = std::ranges::find(names, name);
  if (at == names.end()) return std::nullopt;
  return static_cast<std::size_t>(at - names.begin());
}

// "odomd@can0" for the segment "/run/odomd/can0/pose" of a service; empty if odomd was started by
// hand.
std::string service_of(const StatusValue& status) {
  constexpr std::string_view folder = "/run/odomd/";
  const std::string segment = status["shm"].text();
  const std::size_t end = segment.rfind('/');
  if (!segment.starts_with(folder) || end <= folder.size()) return {};
  return "odomd@" + segment.substr(folder.size(), end - folder.size());
}

void examine_version(const StatusValue& status, Diagnostics& all) {
  const std::string version = status["version"].text();
  if (version == ODOMD_VERSION) return;
  const std::string service = service_of(status);
  all.push_back(found(kind("other_version"), "odomd",
                      fmt::format("has version {}, odom has {}", version, ODOMD_VERSION),
                      service.empty() ? "odomd@can0" : service));
}

void examine_grants(const StatusValue& status, const Machine& machine, Diagnostics& all) {
  const StatusValue granted = status["realtime"];
  if (!granted.exists()) return;
  if (granted["priority"].value() == 0.0)
    all.push_back(found(kind("no_realtime_priority"), "odomd",
                        "its beat has no real-time priority, so other programs delay the poses",
                        fmt::format("{} - rtprio 99", machine.user)));
  if (!granted["memory_locked"].is_true())
    all.push_back(found(kind("memory_not_locked"), "odomd",
                        "its memory is not locked, so a tick may wait for the disk", machine.user));
  constexpr const Kind& sleep = kind("cpus_sleep_deeply");
  if (!granted["dma_latency_held"].is_true() && !sleep.limits.hold(machine.deepest_sleep_us))
    all.push_back(
        found(sleep, "odomd",
              fmt::format("may not open /dev/cpu_dma_latency: CPUs wake {:.0f} µs late from their "
                          "deepest sleep",
                          machine.deepest_sleep_us),
              service_of(status).empty() ? machine.group : "odomd"));
  for (const StatusValue& refusal : granted["refusals"].elements())
    if (refusal.text().find("is not pinned") != std::string::npos)
      all.push_back(found(kind("cpu_not_pinned"), "odomd", refusal.text()));
}

void examine_beat(const StatusValue& status, Diagnostics& all) {
  const StatusValue beat = status["beat"];
  if (!beat.exists()) return;
  constexpr double us = 1e-6;
  const double works_s = us * beat["execution_us/p999"].value();
  const double period_s = beat["period_s"].value(1.0);
  constexpr const Kind& long_ticks = kind("ticks_too_long");
  if (!long_ticks.limits.hold(works_s / period_s)) {
    all.push_back(found(long_ticks, "odomd",
                        fmt::format("a tick works for up to {:.1f} ms, its period is {:.1f} ms",
                                    1e3 * works_s, 1e3 * period_s)));
    return;
  }
  // Without real-time priority a thread misses ticks on any machine.
  if (status["realtime/priority"].value() == 0.0) return;
  const double missed = beat["missed"].value();
  const double cycles = std::max(missed + beat["ticks"].value(), 1.0);
  constexpr const Kind& late = kind("beat_wakes_late");
  if (late.limits.hold(missed / cycles)) return;
  all.push_back(found(late, "odomd",
                      fmt::format("missed {:.0f} of {:.0f} cycles; it woke up to {:.1f} ms late",
                                  missed, cycles, 1e-3 * beat["wakeup_us/max"].value())));
}

enum class Traffic { none, comes, ended };

// Reports faults of the whole traffic on the buses, and returns whether frames arrive.
Traffic examine_buses(const StatusValue& status, Diagnostics& all) {
  Traffic traffic = Traffic::none;
  bool ended = false;
  const double uptime_s = status["uptime_s"].value();
  for (const StatusValue& bus : status["can"].elements()) {
    const std::string name = bus["name"].text();
    const std::string link = bus["link"].text();
    ended |= link == "ended";
    const double received = bus["received"].value();
    if (link == "up" && received > 0.0) traffic = Traffic::comes;
    if (link == "up" && received == 0.0 && uptime_s > settled_s)
      all.push_back(found(kind("no_frames"), name,
                          fmt::format("no frame came since odomd started {:.0f} s ago", uptime_s)));
    const auto examine_losses = [&](const Kind& lost, const std::string& key) {
      const double count = bus[key].value();
      if (!lost.limits.hold(count / std::max(count + received, 1.0)))
        all.push_back(found(
            lost, name, fmt::format("{:.0f} frames are lost, {:.0f} arrived", count, received)));
    };
    examine_losses(kind("frames_lost"), "lost");
    examine_losses(kind("controller_overflows"), "controller_overflows");
  }
  if (ended) return Traffic::ended;
  // Frames have arrived; the age of the newest mapped one shows whether they still arrive.
  double youngest_s = std::numeric_limits<double>::infinity();
  for (const StatusValue& message : status["messages"].elements())
    youngest_s =
        std::min(youngest_s, message["age_s"].value(std::numeric_limits<double>::infinity()));
  if (traffic != Traffic::comes || !std::isfinite(youngest_s) || youngest_s < silent_s)
    return traffic;
  all.push_back(found(kind("no_frames"), "odomd",
                      fmt::format("the last mapped frame came {:.0f} s ago", youngest_s)));
  return Traffic::none;
}

void examine_messages(const StatusValue& status, Diagnostics& all) {
  for (const StatusValue& message : status["messages"].elements()) {
    const std::string name = fmt::format("message '{}'", message["name"].text());
    const StatusValue verdicts = message["verdicts"];
    if (!verdicts.exists()) continue;
    if (verdicts.count() == 0)
      all.push_back(found(kind("message_missing"), name, "was never received"));
    else if (verdicts["decoded"].value() == 0.0)
      all.push_back(found(kind("message_without_value"), name,
                          fmt::format("none of its {} frames gave a value", verdicts.count())));
  }
}

// Reports each wiring or configuration mistake once for all its sources, and returns whether it
// found one.
bool examine_wiring(const StatusValue& status, Diagnostics& all) {
  bool any = false;
  for (std::size_t fault = 1; fault < daemon::wiring_names.size(); ++fault) {
    std::vector<std::string> sources;
    for (const StatusValue& source : status["sources"].elements())
      if (source["wiring"].text() == daemon::wiring_names[fault])
        sources.push_back(source["name"].text());
    if (sources.empty()) continue;
    append(all, daemon::diagnostic_of(static_cast<daemon::WiringFault>(fault), sources.front(),
                                      fmt::format("{}", fmt::join(sources, ", "))));
    any = true;
  }
  return any;
}

std::optional<diagnostics::Diagnostic> check_statistics(const StatusValue& source,
                                                        const std::string& name) {
  const StatusValue innovations = source["innovations"];
  const double dimension = innovations["dimension"].value();
  const auto index = index_in(estimator::source_names, name);
  if (dimension == 0.0 || !index || innovations["count"].value() < static_cast<double>(min_samples))
    return std::nullopt;
  const auto count_of = [&](const char* key) {
    return static_cast<std::uint64_t>(innovations[key].value());
  };
  if (auto gated = check_gating(static_cast<estimator::Source>(*index), name, count_of("gated"),
                                count_of("count")))
    return gated;
  constexpr const Kind& sigma = kind("sigma_off");
  const double ratio = innovations["mean_nis"].value(dimension) / dimension;
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

bool is_overdue(const StatusValue& source) {
  const std::string flag = source["flag"].text();
  const double age_s = source["age_s"].value(-1.0);
  return !source["healthy"].is_true() && (flag == "ok" || flag == "timed_out") &&
         age_s > source["timeout_s"].value(age_s);
}

void examine_sources(const StatusValue& status, Diagnostics& all) {
  const bool miswired = examine_wiring(status, all);
  std::vector<std::string> overdue;
  double age_s = 0.0;
  for (const StatusValue& source : status["sources"].elements()) {
    if (!source["configured"].is_true()) continue;
    const std::string name = source["name"].text();
    const auto flag = static_cast<estimator::SourceFlag>(
        index_in(estimator::source_flag_names, source["flag"].text()).value_or(0));
    const bool contradicts = flag == estimator::SourceFlag::drifting;
    if (!(miswired && contradicts)) append(all, daemon::diagnostic_of(flag, name));
    if (is_overdue(source)) {
      overdue.push_back(name);
      age_s = std::max(age_s, source["age_s"].value());
    }
    if (miswired || flag != estimator::SourceFlag::ok) continue;
    if (source["inconsistent"].is_true())
      all.push_back(daemon::inconsistent_source(name));
    else
      append(all, check_statistics(source, name));
  }
  if (overdue.empty()) return;
  const auto buses = status["can"].elements();
  all.push_back(found(kind("signal_overdue"), fmt::format("{}", fmt::join(overdue, ", ")),
                      fmt::format("last came {:.3g} s ago", age_s),
                      buses.empty() ? "can0" : buses.front()["name"].text()));
}

void examine_camera(const StatusValue& status, Diagnostics& all) {
  const StatusValue camera = status["camera"];
  if (!camera.exists() || camera["socket"].text().empty()) return;
  const double malformed = camera["malformed"].value();
  if (malformed > 0.0)
    all.push_back(found(kind("camera_messages_malformed"), "camera",
                        fmt::format("{:.0f} messages were not camera poses", malformed)));
  const StatusValue source = status["sources"].named("camera");
  const double age_s = source["age_s"].value(status["uptime_s"].value());
  if (age_s > silent_s && malformed == 0.0)
    all.push_back(found(
        kind("camera_silent"), "camera",
        fmt::format(
            "no pose came for {:.0f} s{}", age_s,
            status["mode"].text() == "initialising" ? "; odomd waits for the first one" : "")));
  const StatusValue verdicts = source["verdicts"];
  if (!verdicts.exists()) return;
  const double unusable = verdicts["too_old"].value() + verdicts["future"].value();
  constexpr const Kind& times = kind("camera_times");
  if (!times.limits.hold(unusable / std::max(static_cast<double>(verdicts.count()), 1.0)))
    all.push_back(found(times, "camera",
                        fmt::format("{:.0f} of its {} poses were too old or from the future",
                                    unusable, verdicts.count())));
}

}  // namespace

Diagnostics examine_daemon(const Json& document, const Machine& machine) {
  const StatusValue status{document};
  Diagnostics all;
  examine_version(status, all);
  examine_grants(status, machine, all);
  examine_beat(status, all);
  const Traffic traffic = examine_buses(status, all);
  for (const StatusValue& condition : status["conditions"].elements()) {
    if (condition.text() == "model_fault")
      all.push_back(found(kind("model_fault"), "odomd", "its model stopped"));
    if (condition.text() == "camera_refused")
      all.push_back(found(kind("camera_refused"), "camera",
                          "a connection was refused within the last ten seconds"));
    if (condition.text() == "bias_unlearnt") all.push_back(daemon::unlearnt_bias());
    if (condition.text() == "scale_implausible") all.push_back(daemon::implausible_scale());
  }
  if (traffic == Traffic::comes && status["uptime_s"].value() > settled_s) {
    examine_messages(status, all);
    examine_sources(status, all);
  }
  if (traffic != Traffic::ended) examine_camera(status, all);
  return all;
}

}  // namespace odomd::tools::doctor
