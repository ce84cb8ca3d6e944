#include "daemon/housekeeping/source_reporter.hpp"

#include <fmt/format.h>

#include <string_view>

#include "daemon/core/pipeline.hpp"
#include "daemon/core/source_diagnostics.hpp"

namespace odomd::daemon {
namespace {

using can::LinkState;

}  // namespace

SourceReporter::SourceReporter(const Running& running)
    : running_(running), buses_(running.sources.size()) {}

void SourceReporter::update(const PublishedPose& published, std::int64_t now_ns, Journal& journal) {
  check_links(now_ns, journal);
  check_camera_times(journal);
  check_wiring(journal);
  if (!published.valid) return;
  check_learning(published.pose, journal);
  check_signals(published, now_ns, journal);
}

void SourceReporter::check_camera_times(Journal& journal) {
  const auto& camera =
      running_.pipeline.statistics().sources[static_cast<std::size_t>(estimator::Source::camera)];
  const std::uint64_t all = camera.judged();
  const std::uint64_t future =
      camera.verdicts[static_cast<std::size_t>(estimator::Verdict::future)].get();
  if (all < camera_.all + enough_poses) return;
  const bool all_future = all - camera_.all == future - camera_.future;
  if (all_future && !camera_.reported) {
    const std::int64_t latency_ns = camera.last_latency_ns.get();
    if (latency_ns >= 0) return;  // a newer pose came after the counts were read
    journal.warn(
        fmt::format("the last {} camera poses are all stamped in the future, the newest by {:.3f} "
                    "s, and are not used: the camera's clock is ahead of this machine's, or the "
                    "log whose clock it uses is late",
                    future - camera_.future, static_cast<double>(-latency_ns) * 1e-9));
  }
  camera_ = {all, future, all_future};
}

void SourceReporter::check_wiring(Journal& journal) {
  for (std::size_t i = 0; i < wiring_.size(); ++i) {
    const SourceStatistics& source = running_.pipeline.statistics().sources[i];
    const std::string_view name = estimator::source_names[i];
    const auto wiring = static_cast<WiringFault>(source.wiring.get());
    if (wiring != wiring_[i])
      wiring == WiringFault::none
          ? journal.info(fmt::format("{} agrees with the other sensors again", name))
          : journal.warn(text_of(diagnostic_of(wiring, name, std::string{name}).value()));
    wiring_[i] = wiring;
    const bool inconsistent = source.inconsistent.get() != 0;
    if (inconsistent != inconsistent_[i])
      inconsistent ? journal.warn(text_of(inconsistent_source(std::string{name})))
                   : journal.info(fmt::format("{} fits the filter's prediction again", name));
    inconsistent_[i] = inconsistent;
  }
}

void SourceReporter::check_learning(const odom_pose& pose, Journal& journal) {
  const auto report = [&](bool is, bool& was, const diagnostics::Diagnostic& warning,
                          const char* over) {
    if (is != was) is ? journal.warn(text_of(warning)) : journal.info(over);
    was = is;
  };
  // While the car is at rest, the filter learns the gyro's bias.
  const bool at_rest = pose.mode == ODOM_INITIALISING || pose.mode == ODOM_STANDSTILL;
  report((pose.conditions & ODOM_COND_BIAS_UNLEARNT) != 0 && (bias_unlearnt_ || !at_rest),
         bias_unlearnt_, unlearnt_bias(), "the gyro's bias is known");
  report((pose.conditions & ODOM_COND_SCALE_IMPLAUSIBLE) != 0, scale_implausible_,
         implausible_scale(), "the learnt scales are plausible again");
}

void SourceReporter::check_links(std::int64_t now_ns, Journal& journal) {
  for (std::size_t i = 0; i < buses_.size(); ++i) {
    const can::FrameSource& source = *running_.sources[i];
    Bus& bus = buses_[i];
    const LinkState link = source.link();
    const std::uint64_t link_downs = source.counters().link_downs.get();
    const std::uint64_t error_frames = source.counters().error_frames.get();
    if (link != bus.link || link_downs != bus.link_downs || error_frames != bus.error_frames)
      running_.controllers.look_again();
    bus.link_downs = link_downs;
    bus.error_frames = error_frames;
    if (link != bus.link) {
      const std::string& name = source.name();
      switch (link) {
        case LinkState::up:
          journal.info(fmt::format("{}: the bus is up again", name));
          break;
        case LinkState::down:
          journal.warn(
              fmt::format("{}: the bus is down; bring it up: ip link set {} up", name, name));
          break;
        case LinkState::gone:
          journal.warn(fmt::format("{}: interface not found; waiting for it", name));
          break;
        case LinkState::ended:
          journal.info(fmt::format("{}: has ended after {} frames",
                                   name == "-" ? "standard input" : name,
                                   source.counters().received.get()));
          break;
      }
      bus.link = link;
    }
    if (const std::uint64_t lost = source.counters().lost.get(); lost != bus.lost) {
      journal.warn_counted(
          fmt::format("{}: the kernel dropped {} frames; raise [can] receive_buffer", source.name(),
                      lost - bus.lost));
      bus.lost = lost;
    }
    const std::vector<std::string> warnings = source.warnings();
    for (; bus.warnings_logged < warnings.size(); ++bus.warnings_logged)
      journal.warn(warnings[bus.warnings_logged]);
    check_controller(i, now_ns, journal);
  }
}

void SourceReporter::check_controller(std::size_t index, std::int64_t now_ns, Journal& journal) {
  constexpr std::int64_t second_ns = 1'000'000'000;  // the longest time to the next query
  const can::FrameSource& source = *running_.sources[index];
  const auto controller = running_.controllers.latest(index);
  Bus& bus = buses_[index];
  if (controller && now_ns >= bus.controller_ns + second_ns) {
    if (const auto report = report_change(bus.controller, source.name(), *controller)) {
      report->severity == Severity::warning ? journal.warn(report->text)
                                            : journal.info(report->text);
      bus.controller_ns = now_ns;
    }
  }
  // For a bus-off that ended before the query, and for controllers in a log, use the error frames.
  const std::uint64_t bus_offs = source.counters().bus_offs.get();
  if (bus.controller == can::ControllerHealth::bus_off) bus.bus_offs = bus_offs;
  if (bus_offs == bus.bus_offs) {
    bus.bus_off_ns = 0;
    return;
  }
  if (bus.bus_off_ns == 0) bus.bus_off_ns = now_ns;
  if (controller && now_ns < bus.bus_off_ns + second_ns) return;  // the next query may show it
  journal.warn_counted(
      fmt::format("{}: bus-off: an error frame reports that a controller has left this "
                  "bus; frames may be missing",
                  source.name()));
  bus.bus_offs = bus_offs;
}

void SourceReporter::check_signals(const PublishedPose& published, std::int64_t now_ns,
                                   Journal& journal) {
  for (std::size_t i = 0; i < signals_.size(); ++i) {
    if (!running_.config.can.signals[i].configured) continue;
    Signal& signal = signals_[i];
    const can::SignalBinding& binding =
        *binding_of(running_.config, static_cast<estimator::Source>(i));
    const auto flag =
        static_cast<estimator::SourceFlag>(running_.pipeline.statistics().sources[i].flag.get());
    // While a wiring fault is reported for the source, do not report drift or recovery.
    if (wiring_[i] != WiringFault::none &&
        (flag == estimator::SourceFlag::ok || flag == estimator::SourceFlag::drifting))
      continue;
    // Wheel slip is common and is only shown in the status.
    const bool healthy =
        (published.pose.health >> i & 1U) != 0 || flag == estimator::SourceFlag::slipping;
    const auto label = [&] {
      return fmt::format("{} ({})", estimator::source_names[i], binding.message);
    };
    if (healthy) {
      if (signal == Signal::unhealthy) journal.info(label() + " is fine again");
      signal = Signal::healthy;
    } else if (signal == Signal::healthy) {
      // The time since reception: source_age_ns includes the latency of the sensor.
      const std::int64_t unheard_ns = published.details.source_age_ns[i] - binding.latency_ns;
      const bool overdue = unheard_ns > running_.config.can.signals[i].timeout_ns;
      if (overdue && inputs_ended(running_)) continue;  // already reported; no sender is at fault
      const auto wrong = overdue ? std::nullopt : diagnostic_of(flag, label());
      journal.warn(wrong ? text_of(*wrong)
                         : fmt::format("{} is overdue: the last sample is {:.3f} s old", label(),
                                       static_cast<double>(unheard_ns) * 1e-9));
      signal = Signal::unhealthy;
    } else if (signal == Signal::awaited &&
               now_ns - running_.started_ns > first_sample_timeout_ns) {
      journal.warn(
          text_of(found(diagnostics::kind("message_missing"), label(), "was never received")));
      signal = Signal::unhealthy;
    }
  }
}

}  // namespace odomd::daemon
