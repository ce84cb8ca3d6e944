#include "daemon/housekeeping/housekeeping.hpp"

#include <poll.h>
#include <sys/signalfd.h>
#include <sys/socket.h>
#include <systemd/sd-daemon.h>
#include <unistd.h>
#include <csignal>

#include <algorithm>
#include <array>
#include <cerrno>
#include <cinttypes>
#include <utility>

#include <fmt/format.h>
#include <fmt/ranges.h>

#include "base/seconds.hpp"
#include "base/wall_clock.hpp"
#include "daemon/core/conditions.hpp"

namespace odomd::daemon {
namespace {

constexpr int turn_ms = 20;
constexpr int accepts_per_turn =
    16;  // per socket: a flood of connections does not block housekeeping
constexpr std::int64_t linger_ns = 200'000'000;  // after the last input has ended
constexpr std::int64_t mode_every_ns = 1'000'000'000;
constexpr std::int64_t files_every_ns = 500'000'000;
constexpr std::int64_t status_every_ns = 1'000'000'000;  // to the service manager

double milliseconds(std::int64_t ns) {
  return static_cast<double>(ns) * 1e-6;
}

}  // namespace

Housekeeping::Housekeeping(const Running& running, Journal& journal, FileDescriptor signals,
                           std::optional<LocalSocket> camera, std::optional<LocalSocket> status,
                           std::optional<RecorderServer> recorders, AtEnd at_end)
    : running_(running),
      journal_(journal),
      sources_(running),
      signals_(std::move(signals)),
      camera_(std::move(camera)),
      status_(std::move(status)),
      recorders_(std::move(recorders)),
      camera_group_(running.config.camera.socket.group.empty()
                        ? ::getegid()
                        : group_named(running.config.camera.socket.group)),
      at_end_(at_end) {}

void Housekeeping::run() {
  while (!stop_) {
    std::array<pollfd, 4> inputs{pollfd{signals_.get(), POLLIN, 0},
                                 pollfd{camera_ ? camera_->get() : -1, POLLIN, 0},
                                 pollfd{status_ ? status_->get() : -1, POLLIN, 0},
                                 pollfd{recorders_ ? recorders_->socket().get() : -1, POLLIN, 0}};
    ::poll(inputs.data(), inputs.size(), turn_ms);
    const std::int64_t now_ns = monotonic_now();
    journal_.turn(now_ns);
    if (inputs[0].revents != 0) read_signals();
    running_.cameras.close_ended(now_ns);  // first, to make room
    if (inputs[1].revents != 0) accept_cameras(now_ns);
    if (inputs[2].revents != 0) serve_status(now_ns);
    // In this order, so that a recorder that disconnected does not block the next one.
    if (recorders_) recorders_->serve(now_ns, journal_);
    if (inputs[3].revents != 0) recorders_->accept(now_ns, journal_);
    for (const auto& source : running_.sources) source->maintain();
    report_events();
    const PublishedPose seen = published();
    if (seen.valid) report_mode(seen.pose, now_ns);
    sources_.update(seen, now_ns, journal_);
    check_files(now_ns);
    check_end(now_ns);
    notify_service_manager(now_ns);
  }
  ::sd_notify(0, "STOPPING=1");
  if (recorders_) recorders_->close(journal_);
}

void Housekeeping::read_signals() {
  signalfd_siginfo info{};
  while (::read(signals_.get(), &info, sizeof info) == sizeof info) {
    if (info.ssi_signo == SIGHUP) {
      journal_.reopen();
    } else {
      journal_.info(fmt::format("stopping: signal {}", info.ssi_signo == SIGINT ? "INT" : "TERM"));
      stop_ = true;
    }
  }
}

void Housekeeping::accept_cameras(std::int64_t now_ns) {
  for (int i = 0; i < accepts_per_turn; ++i) {
    auto connection = camera_->accept();
    if (!connection) return;
    const Peer peer = peer_of(connection.get());
    if (!peer_is_welcome(connection.get(), camera_group_, running_.config.camera.socket.mode)) {
      journal_.warn_counted(
          fmt::format("a camera process (pid {}, uid {}) was refused; add its user to "
                      "the group of [camera] socket_group",
                      peer.pid, peer.uid));
      running_.cameras.refuse(std::move(connection), -EACCES);
      continue;
    }
    const auto admission = running_.cameras.admit(std::move(connection), peer, now_ns);
    if (admission == CameraServer::Admission::refused)
      journal_.warn_counted(fmt::format(
          "a camera process (pid {}) was refused: {} are already connected; stop one of them",
          peer.pid, CameraServer::max_connections));
    else
      journal_.info_counted(
          fmt::format("a camera process connected (pid {}, uid {}){}", peer.pid, peer.uid,
                      admission == CameraServer::Admission::free_slot
                          ? ""
                          : " in place of one that sent no valid pose for 2 s: all were taken"));
  }
}

void Housekeeping::serve_status(std::int64_t now_ns) {
  const std::string document = status_json(running_, published(), now_ns);
  for (int i = 0; i < accepts_per_turn; ++i) {
    const auto connection = status_->accept();
    if (!connection) return;
    // The document is much smaller than the socket's buffer, so a client that does not read blocks
    // nobody.
    static_cast<void>(::send(connection.get(), document.data(), document.size(), MSG_NOSIGNAL));
  }
}

void Housekeeping::report_events() {
  while (const auto event = running_.events.next()) report(*event);
}

void Housekeeping::report(const Event& event) {
  switch (event.kind) {
    case EventKind::overrun:
      journal_.warn_counted(
          fmt::format("tick overrun: execution time {:.3f} ms, wake-up latency {:.3f} ms",
                      milliseconds(event.a), milliseconds(event.b)));
      break;
    case EventKind::missed:
      journal_.warn_counted(fmt::format("ticks missed: {}; wake-up latency {:.3f} ms", event.a,
                                        milliseconds(event.b)));
      break;
    case EventKind::pose_reset:
      journal_.info_counted(fmt::format("the map pose was reset (reset {})", event.a));
      break;
    case EventKind::clock_stepped:
      journal_.warn_counted(
          fmt::format("the wall clock was stepped by {:+.6f} s", seconds(event.a)));
      break;
    case EventKind::suspended:
      journal_.warn_counted(fmt::format(
          "the machine was suspended; the wall clock moved by {:+.3f} s", seconds(event.a)));
      break;
    case EventKind::camera_gone:
      journal_.info_counted("a camera process disconnected");
      break;
    case EventKind::camera_malformed:
      journal_.warn_counted(fmt::format("a camera message was invalid: {}",
                                        malformed_texts[static_cast<std::size_t>(event.a)]));
      break;
  }
}

void Housekeeping::report_mode(const odom_pose& pose, std::int64_t now_ns) {
  if (pose.mode == logged_mode_ || now_ns - mode_logged_ns_ < mode_every_ns) return;
  const auto names = condition_names(pose.conditions);
  const auto because = names.empty() ? std::string() : fmt::format(" ({})", fmt::join(names, ", "));
  const std::string text = fmt::format("mode: {}{}, was {}", odom_mode_name(pose.mode), because,
                                       odom_mode_name(logged_mode_));
  const bool matters = pose.mode == ODOM_FAULT || pose.mode == ODOM_DEGRADED ||
                       (pose.mode == ODOM_DEAD_RECKONING && logged_mode_ == ODOM_TRACKING);
  matters ? journal_.warn(text) : journal_.info(text);
  logged_mode_ = pose.mode;
  mode_logged_ns_ = now_ns;
}

void Housekeeping::check_files(std::int64_t now_ns) {
  if (now_ns - files_seen_ns_ < files_every_ns) return;
  files_seen_ns_ = now_ns;
  check_segment();
  if (camera_) check_socket(*camera_);
  if (status_) check_socket(*status_);
  if (recorders_) check_socket(recorders_->socket());
}

void Housekeeping::check_socket(LocalSocket& socket) {
  try {
    if (socket.renew())
      journal_.warn(
          fmt::format("{}: the socket was removed or replaced while odomd was running; it has been "
                      "recreated: leave it in place",
                      socket.path().string()));
  } catch (const std::exception& error) {
    journal_.warn_counted(fmt::format(
        "a socket was removed while odomd was running and cannot be recreated: {}", error.what()));
  }
}

void Housekeeping::check_segment() {
  const std::string& name = running_.config.shm.name;
  try {
    switch (running_.writer.maintain()) {
      case shm::Upkeep::unchanged:
        break;
      case shm::Upkeep::lock_renewed:
        journal_.warn(fmt::format(
            "{}.lock was removed while odomd was running; it has been recreated: leave it in place",
            name));
        break;
      case shm::Upkeep::recreated:
        journal_.warn(
            fmt::format("{}: the segment was removed or replaced while odomd was running; it has "
                        "been recreated, and readers switch to the new one: leave it in place",
                        name));
    }
  } catch (const shm::Displaced&) {
    throw;
  } catch (const std::exception& error) {
    journal_.warn(
        fmt::format("the segment was removed while odomd was running and cannot be recreated: {}",
                    error.what()));
  }
}

void Housekeeping::check_end(std::int64_t now_ns) {
  if (!inputs_ended(running_)) {
    ended_ns_ = 0;
  } else if (ended_ns_ == 0) {
    ended_ns_ = now_ns;
    if (at_end_ == AtEnd::go_on)
      journal_.info("all inputs have ended; continuing (--exit-at-end would stop here)");
  } else if (at_end_ == AtEnd::exit && now_ns - ended_ns_ > linger_ns) {
    const bool any = std::ranges::any_of(
        running_.sources, [](const auto& source) { return source->counters().received.get() > 0; });
    if (!any)
      throw std::runtime_error(
          "all inputs have ended without a frame of a mapped message; check what is piped in, and "
          "that [can] dbc names this car's databases");
    journal_.info("stopping: all inputs have ended");
    stop_ = true;
  }
}

void Housekeeping::notify_service_manager(std::int64_t now_ns) {
  const std::uint64_t ticks = running_.beat.counters().ticks.get();
  if (!ready_ && ticks > 0) {
    ::sd_notify(0, "READY=1");
    ready_ = true;
  }
  watchdog_.notify(ticks, now_ns);
  if (now_ns - last_status_ns_ < status_every_ns) return;
  last_status_ns_ = now_ns;
  const auto seen = published();
  ::sd_notifyf(0, "STATUS=%s, %" PRIu64 " poses", odom_mode_name(seen.pose.mode), ticks);
}

PublishedPose Housekeeping::published() {
  PublishedPose seen;
  if (!client_) {
    odom_client* client = nullptr;
    if (odom_open(running_.config.shm.name.c_str(), &client) != ODOM_OK) return seen;
    client_.reset(client);
  }
  const odom_status status = odom_latest_details(client_.get(), &seen.pose, sizeof seen.pose,
                                                 &seen.details, sizeof seen.details);
  seen.valid = status == ODOM_OK || status == ODOM_STALE;
  return seen;
}

}  // namespace odomd::daemon
