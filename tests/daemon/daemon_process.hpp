// A running odomd for tests: its directory with configuration and database, its process, its
// status, and a client that reads its poses.
#pragma once

#include <sys/types.h>

#include <chrono>
#include <cstdint>
#include <filesystem>
#include <functional>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include <odom/odom.h>

namespace odomd::testing {

/// Tries `condition` until it holds; false after ten seconds of trying.
[[nodiscard]] bool eventually(const std::function<bool()>& condition);

/// A directory of one test, with `car.toml` and `car.dbc` of a car whose bus carries a speed
/// (0x100), a yaw rate (0x101) and a steering angle (0x102). Removed at the end, with the segment.
class Desk {
 public:
  Desk();
  ~Desk();
  Desk(const Desk&) = delete;
  Desk& operator=(const Desk&) = delete;

  [[nodiscard]] std::filesystem::path file(const std::string& name) const {
    return directory_ / name;
  }
  void write(const std::string& name, const std::string& text) const;
  [[nodiscard]] std::string read(const std::string& name) const;
  [[nodiscard]] const std::string& segment() const { return segment_; }

  /// Poses, modes and the like, asked of the status socket; null where there is none.
  [[nodiscard]] nlohmann::json status() const;

 private:
  std::filesystem::path directory_;
  std::string segment_;
};

/// A drive straight ahead at `speed`, every 10 ms for so long, as candump -L writes it. Up to five
/// seconds fit into a pipe at once.
[[nodiscard]] std::string straight_drive(double seconds, double speed);

/// odomd with a desk's configuration. Its standard input is a pipe; its standard error goes to the
/// desk's file "stderr".
class DaemonProcess {
 public:
  DaemonProcess(const Desk& desk, const std::vector<std::string>& arguments);
  ~DaemonProcess();  ///< kills it where it still runs
  DaemonProcess(const DaemonProcess&) = delete;
  DaemonProcess& operator=(const DaemonProcess&) = delete;

  void feed(const std::string& text) const;
  void close_input();
  void signal(int number) const;
  /// Its exit status; -1 where a signal ended it, -2 where it does not end.
  [[nodiscard]] int wait();
  [[nodiscard]] pid_t pid() const { return pid_; }

 private:
  pid_t pid_ = -1;
  int input_ = -1;
};

}  // namespace odomd::testing
