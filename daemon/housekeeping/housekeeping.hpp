// Housekeeping: everything without real-time requirements. It owns the log, the service manager,
// the listening sockets and the signals; the beat only sends it events.
#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <string>

#include <odom/odom.h>

#include "base/file_descriptor.hpp"
#include "daemon/housekeeping/process_control.hpp"
#include "daemon/housekeeping/running.hpp"
#include "daemon/housekeeping/source_reporter.hpp"
#include "daemon/housekeeping/status.hpp"
#include "daemon/journal/journal.hpp"
#include "daemon/sockets/local_socket.hpp"
#include "daemon/sockets/recorder_server.hpp"

namespace odomd::daemon {

/// What to do when all logs and pipes have ended.
enum class AtEnd : std::uint8_t { go_on, exit };

class Housekeeping {
 public:
  /// `signals` is a signalfd of TERM, INT and HUP.
  Housekeeping(const Running& running, Journal& journal, FileDescriptor signals,
               std::optional<LocalSocket> camera, std::optional<LocalSocket> status,
               std::optional<RecorderServer> recorders, AtEnd at_end);

  /// Returns when the daemon is to stop. Throws when it must not continue because another daemon
  /// publishes under its name.
  void run();

 private:
  void read_signals();
  void accept_cameras(std::int64_t now_ns);
  void serve_status(std::int64_t now_ns);
  void report_events();
  void report(const Event& event);
  void report_mode(const odom_pose& pose, std::int64_t now_ns);
  void check_files(std::int64_t now_ns);
  void check_segment();
  void check_socket(LocalSocket& socket);
  void check_end(std::int64_t now_ns);
  void notify_service_manager(std::int64_t now_ns);
  [[nodiscard]] PublishedPose published();

  struct CloseClient {
    void operator()(odom_client* client) const { odom_close(client); }
  };

  const Running& running_;
  Journal& journal_;
  Watchdog watchdog_;
  SourceReporter sources_;
  FileDescriptor signals_;
  std::optional<LocalSocket> camera_;
  std::optional<LocalSocket> status_;
  std::optional<RecorderServer> recorders_;
  gid_t camera_group_ = 0;
  AtEnd at_end_;
  std::unique_ptr<odom_client, CloseClient> client_;  // reads what the beat publishes
  std::int64_t files_seen_ns_ = 0;
  std::int64_t ended_ns_ = 0;  // when the last input was seen to have ended; 0: some still run
  std::int64_t last_status_ns_ = 0;
  std::uint32_t logged_mode_ = ODOM_INITIALISING;  // logged last; at most one change a second
  std::int64_t mode_logged_ns_ = 0;
  bool ready_ = false;
  bool stop_ = false;
};

}  // namespace odomd::daemon
