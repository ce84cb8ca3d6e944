#include "daemon/housekeeping/source_reporter.hpp"

#include <fmt/format.h>

#include <string_view>

#include "daemon/core/source_complaint.hpp"

namespace odomd::daemon {
namespace {

using can::LinkState;

/// What feeds a source; every configured one has a binding.
can::SignalBinding binding_of(const Config& config, std::size_t source) {
  for (const auto& binding : config.can.bindings)
    if (binding.channel == source) return binding;
  return {};
}

}  // namespace

SourceReporter::SourceReporter(const Running& running)
    : running_(running), buses_(running.sources.size()) {}

void SourceReporter::look(const PublishedPose& published, std::int64_t now_ns, Journal& journal) {
  look_at_links(now_ns, journal);
  look_at_camera_times(journal);
  look_at_wiring(journal);
  if (published.valid) look_at_signals(published, now_ns, journal);
}

void SourceReporter::look_at_camera_times(Journal& journal) {
  const auto& camera =
      running_.pipeline.statistics().sources[static_cast<std::size_t>(estimator::Source::camera)];
  const auto count = [&](estimator::Verdict verdict) {
    return camera.verdicts[static_cast<std::size_t>(verdict)].get();
  };
  const std::uint64_t future = count(estimator::Verdict::future);
  const std::uint64_t in_time = count(estimator::Verdict::fused) + count(estimator::Verdict::gated);
  if (future + in_time < camera_.future + camera_.in_time + enough_poses) return;
  const bool all_future = in_time == camera_.in_time;
  if (all_future && !camera_.told) {
    const auto latency_ns = static_cast<std::int64_t>(camera.last_latency_ns.get());
    journal.warn(fmt::format(
        "the camera's last {} poses are all stamped in the future, the newest by {:.3f} s, and are "
        "not used: its clock is ahead of this machine's, or the log whose clock it names comes "
        "late",
        future - camera_.future, static_cast<double>(-latency_ns) * 1e-9));
  }
  camera_ = {future, in_time, all_future};
}

void SourceReporter::look_at_wiring(Journal& journal) {
  for (std::size_t i = 0; i < wiring_.size(); ++i) {
    const SourceStatistics& source = running_.pipeline.statistics().sources[i];
    const std::string_view name = estimator::source_names[i];
    const auto wiring = static_cast<WiringFault>(source.wiring.get());
    if (wiring != wiring_[i])
      wiring == WiringFault::none
          ? journal.info(fmt::format("{} agrees with the others again", name))
          : journal.warn(fmt::format("{}{}", name, complaint(wiring, name)));
    wiring_[i] = wiring;
    const bool inconsistent = source.inconsistent.get() != 0;
    if (inconsistent != inconsistent_[i])
      inconsistent ? journal.warn(fmt::format("{}{}", name, inconsistent_complaint))
                   : journal.info(fmt::format("{} fits what the filter expects again", name));
    inconsistent_[i] = inconsistent;
  }
}

void SourceReporter::look_at_links(std::int64_t now_ns, Journal& journal) {
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
          journal.warn(fmt::format("{}: there is no such interface; it is waited for", name));
          break;
        case LinkState::ended:
          journal.info(fmt::format("{}: has ended after {} frames; the pose goes on without it",
                                   name == "-" ? "standard input" : name,
                                   source.counters().received.get()));
          break;
      }
      bus.link = link;
    }
    if (const std::uint64_t lost = source.counters().lost.get(); lost != bus.lost) {
      journal.warn(Topic::frames_lost, now_ns,
                   fmt::format("{}: the kernel dropped {} frames; raise [can] receive_buffer",
                               source.name(), lost - bus.lost));
      bus.lost = lost;
    }
    const std::vector<std::string> complaints = source.complaints();
    for (; bus.complaints_told < complaints.size(); ++bus.complaints_told)
      journal.warn(complaints[bus.complaints_told]);
    look_at_controller(i, now_ns, journal);
  }
}

void SourceReporter::look_at_controller(std::size_t bus, std::int64_t now_ns, Journal& journal) {
  const can::FrameSource& source = *running_.sources[bus];
  const auto controller = running_.controllers.latest(bus);
  if (const auto news = buses_[bus].controller.look(source.name(), controller, now_ns))
    news->weight == Weight::warning ? journal.warn(news->text) : journal.info(news->text);

  // Of controllers that cannot be asked, as those in a log, error frames tell.
  std::uint64_t& told = buses_[bus].bus_offs;
  const std::uint64_t bus_offs = source.counters().bus_offs.get();
  if (bus_offs != told && !controller)
    journal.warn(Topic::bus_off, now_ns,
                 fmt::format("{}: bus-off: a controller on this bus has left it, as an error frame "
                             "says; frames may be missing",
                             source.name()));
  told = bus_offs;
}

void SourceReporter::look_at_signals(const PublishedPose& published, std::int64_t now_ns,
                                     Journal& journal) {
  for (std::size_t i = 0; i < signals_.size(); ++i) {
    if (!running_.config.can.signals[i].configured) continue;
    Signal& signal = signals_[i];
    const auto flag =
        static_cast<estimator::SourceFlag>(running_.pipeline.statistics().sources[i].flag.get());
    // While its wiring is named, which is told above, it neither drifts nor is fine.
    if (wiring_[i] != WiringFault::none &&
        (flag == estimator::SourceFlag::ok || flag == estimator::SourceFlag::drifting))
      continue;
    // Wheels slip and grip again all the time; the status says so.
    const bool healthy =
        (published.pose.health >> i & 1U) != 0 || flag == estimator::SourceFlag::slipping;
    const auto label = [&] {
      return fmt::format("{} ({})", estimator::source_names[i],
                         binding_of(running_.config, i).message);
    };
    if (healthy) {
      if (signal == Signal::unhealthy) journal.info(label() + " is fine again");
      signal = Signal::healthy;
    } else if (signal == Signal::healthy) {
      // Since it was heard: the age of the value counts the latency of its sensor as well.
      const std::int64_t unheard_ns =
          published.details.source_age_ns[i] - binding_of(running_.config, i).latency_ns;
      const bool overdue = unheard_ns > running_.config.can.signals[i].timeout_ns;
      journal.warn(overdue ? fmt::format("{} is overdue: the last one is {:.3f} s old", label(),
                                         static_cast<double>(unheard_ns) * 1e-9)
                           : label() + std::string{complaint(flag)});
      signal = Signal::unhealthy;
    } else if (signal == Signal::waited_for && now_ns - running_.started_ns > patience_ns) {
      journal.warn(label() + " was never received: is it on the bus, and is the database right?");
      signal = Signal::unhealthy;
    }
  }
}

}  // namespace odomd::daemon
