#include "daemon/run.hpp"

#include <algorithm>
#include <cerrno>
#include <cstring>
#include <future>
#include <memory>
#include <optional>
#include <stdexcept>
#include <string_view>
#include <system_error>
#include <thread>
#include <utility>
#include <vector>

#include <fmt/format.h>
#include <fmt/ranges.h>

#include "base/wall_clock.hpp"
#include "can_protocol/bus_names.hpp"
#include "can_protocol/sources/open_source.hpp"
#include "daemon/core/pipeline.hpp"
#include "daemon/core/recording_tap.hpp"
#include "daemon/diagnostics/diagnostic.hpp"
#include "daemon/housekeeping/controllers.hpp"
#include "daemon/housekeeping/process_control.hpp"
#include "daemon/housekeeping/running.hpp"
#include "daemon/journal/journal.hpp"
#include "daemon/realtime/beat.hpp"
#include "daemon/realtime/relay.hpp"
#include "daemon/sockets/recorder_server.hpp"
#include "shm_api/writer.hpp"

namespace odomd::daemon {
namespace {

void copy_text(char (&to)[ODOM_TEXT], std::string_view from) {
  from.copy(to, sizeof to - 1);
}

odom_info segment_info(const Config& config) {
  odom_info info{};
  info.period_ns = config.realtime.period_ns;
  info.mass = config.vehicle.mass;
  info.front_axle = config.vehicle.front_axle;
  info.rear_axle = config.vehicle.rear_axle;
  info.yaw_inertia = config.vehicle.yaw_inertia;
  info.cornering_stiffness_front = config.vehicle.cornering_stiffness_front;
  info.cornering_stiffness_rear = config.vehicle.cornering_stiffness_rear;
  info.track_width = config.vehicle.track_width;
  copy_text(info.model, name_of(config.model));
  copy_text(info.version, ODOMD_VERSION);
  return info;
}

std::vector<std::unique_ptr<can::FrameSource>> open_sources(const Config& config,
                                                            const can::Decoder& decoder,
                                                            can::BusNames& buses,
                                                            can::LogClock& log_clock) {
  const auto is_mapped = [&decoder](const can::Frame& frame) { return decoder.is_mapped(frame); };
  can::SocketCanSettings settings;
  for (const auto& message : decoder.messages())
    settings.keys.push_back(can::frame_key(message.id, message.format) |
                            (message.id_mask == can::whole_id ? 0U : can::j1939_group_flag));
  settings.stamps = config.can.timestamps == Timestamps::hardware ? can::StampSource::hardware
                                                                  : can::StampSource::software;
  settings.receive_buffer = config.can.receive_buffer;
  std::vector<std::unique_ptr<can::FrameSource>> sources;
  for (const auto& name : config.can.sources)
    sources.push_back(can::open_source(name, buses, log_clock, settings, is_mapped));
  return sources;
}

/// The interfaces whose controllers are watched: one name per source, empty for logs.
std::vector<std::string> interfaces_of(const Config& config) {
  std::vector<std::string> interfaces;
  for (const auto& name : config.can.sources)
    interfaces.push_back(can::source_kind(name) == can::SourceKind::interface ? name : "");
  return interfaces;
}

/// Resumes from the last pose if it is recent. With log files only, a new drive starts.
bool resume(Pipeline& pipeline, const std::optional<shm::Inheritance>& predecessor,
            const Config& config, const RunSettings& settings) {
  const bool all_files = std::ranges::all_of(config.can.sources, [](const auto& source) {
    return can::source_kind(source) == can::SourceKind::log;
  });
  if (settings.resume == Resume::forbidden || all_files || !predecessor) return false;
  const auto age_ns = resumable_pose_age(predecessor->pose, monotonic_now());
  return age_ns && pipeline.resume(predecessor->pose, predecessor->details, *age_ns);
}

/// Runs the beat in its thread for the lifetime of the object.
class BeatThread {
 public:
  BeatThread(Beat& beat, const RealtimeConfig& config, bool memory_locked, bool resumed)
      : beat_(beat), thread_([this, &config, memory_locked, resumed] {
          ThreadGrant grant = become_realtime(config.priority, config.cpu, "odomd-beat");
          const bool realtime = memory_locked && grant.priority > 0;
          grant_.set_value(std::move(grant));
          Surroundings surroundings(realtime ? 0U : std::uint32_t{ODOM_COND_NOT_REALTIME});
          if (resumed) surroundings.restarted(monotonic_now());
          beat_.run(surroundings);
        }) {}
  ~BeatThread() {
    beat_.stop();
    thread_.join();
  }
  BeatThread(const BeatThread&) = delete;
  BeatThread& operator=(const BeatThread&) = delete;

  [[nodiscard]] ThreadGrant grant() { return grant_.get_future().get(); }

 private:
  Beat& beat_;
  std::promise<ThreadGrant> grant_;
  std::thread thread_;
};

std::string socket_advice(std::string_view by) {
  return fmt::format("set XDG_RUNTIME_DIR to a directory of yours, or name a path by {}", by);
}

/// The status is optional: without its socket the daemon still works.
std::optional<LocalSocket> open_status_socket(const SocketConfig& config, Journal& journal) {
  try {
    return LocalSocket(
        {config, SocketType::stream, socket_advice("--status-socket PATH or [status] socket")});
  } catch (const std::exception& error) {
    journal.warn(fmt::format("odom status is not available: {}", error.what()));
    return std::nullopt;
  }
}

/// Recording is optional as well.
std::optional<RecorderServer> open_recorder_server(const Running& running, Journal& journal) {
  const Config& config = running.config;
  try {
    auto files = recording_files(config);
    return std::optional<RecorderServer>(
        std::in_place,
        Recorded{config, running.buses, running.writer.info().instance_id, running.tap},
        LocalSocket({config.record, SocketType::stream, socket_advice("[record] socket")}),
        std::move(files));
  } catch (const std::exception& error) {
    journal.warn(fmt::format("odom record is not available: {}", error.what()));
    return std::nullopt;
  }
}

std::optional<LocalSocket> open_camera_socket(const CameraConfig& config) {
  if (!config.configured) return std::nullopt;
  return LocalSocket({config.socket, SocketType::packets,
                      socket_advice("--camera-socket PATH or [camera] socket")});
}

}  // namespace

void run_daemon(const Config& config, std::span<const can::Database> databases,
                const diagnostics::Diagnostics& warnings, const RunSettings& settings) {
  if (config.can.sources.empty())
    throw std::invalid_argument(fmt::format(
        "{}: no CAN source is named; give --can can0, or [can] source", config.file.string()));

  auto signals = take_signals();
  Journal journal(config.log);
  for (const auto& warning : warnings) journal.warn(text_of(warning));
  MachineGrant machine = prepare_machine();

  // First, because its lock prevents a second daemon from changing anything else.
  shm::Claim claim({config.shm.name, 1024, config.shm.mode, config.shm.group});
  auto camera_socket = open_camera_socket(config.camera);
  auto status_socket = open_status_socket(config.status, journal);

  const auto expected = expected_buses(config);
  can::BusNames buses;
  for (const auto& bus : expected) static_cast<void>(buses.index_of(bus));
  const auto pipeline =
      std::make_unique<Pipeline>(config, databases, expected, config.camera.configured);
  if (claim.predecessor_is_damaged())
    journal.warn(
        fmt::format("{}: cannot resume from the last pose: it is damaged or from another version; "
                    "starting from the initial pose",
                    config.shm.name));
  const bool resumed = resume(*pipeline, claim.predecessor(), config, settings);

  can::LogClock log_clock(0, config.realtime.period_ns);  // every T_0 is a multiple of the period
  const auto sources = open_sources(config, pipeline->decoder(), buses, log_clock);

  // After everything that can fail: until here the last pose stays available for readers and for
  // the next attempt.
  shm::Writer writer(std::move(claim), segment_info(config));

  CameraServer cameras;
  EventRing events;
  Relay relay(config.realtime.priority, config.realtime.cpu, [&writer] { writer.wake_clients(); });
  const auto tap = std::make_unique<RecordingTap>(*pipeline);
  const auto beat = std::make_unique<Beat>(
      BeatParts{sources, log_clock, cameras, *pipeline, writer, relay, events, *tap},
      config.realtime.period_ns);
  const std::int64_t started_ns = monotonic_now();
  BeatThread thread(*beat, config.realtime, machine.memory_locked, resumed);
  const ThreadGrant granted = thread.grant();
  for (const auto* grant : {&granted, &relay.grant()})
    machine.refusals.insert(machine.refusals.end(), grant->refusals.begin(), grant->refusals.end());

  for (const auto& refusal : machine.refusals) journal.warn(refusal);
  if (resumed) journal.info("resuming from the last pose");
  journal.info(fmt::format("odomd {}: model {}, {} into {}", ODOMD_VERSION, name_of(config.model),
                           fmt::join(config.can.sources, ", "), config.shm.name));

  ControllerWatch controllers(interfaces_of(config));
  const Running running{config, buses,   machine, granted, sources,     log_clock, *pipeline,
                        writer, cameras, events,  *beat,   controllers, *tap,      started_ns};
  Housekeeping(running, journal, std::move(signals), std::move(camera_socket),
               std::move(status_socket), open_recorder_server(running, journal), settings.at_end)
      .run();
}

}  // namespace odomd::daemon
