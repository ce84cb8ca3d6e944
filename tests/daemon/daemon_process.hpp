// A running odomd for tests: its directory with configuration and database, its process, its
// status, and a client that reads its poses.
#pragma once

#include <sys/types.h>

#include <filesystem>
#include <functional>
#include <memory>
#include <nlohmann/json.hpp>

#include <odom/odom.h>

#include "tests/gtest.hpp"
#include "tests/scratch.hpp"

namespace odomd::testing {

/// Tries `condition` until it is true; false after ten seconds.
[[nodiscard]] bool eventually(const std::function<bool()>& condition);

/// A directory of one test, with `car.toml` and `car.dbc` of a car whose bus carries a speed
/// (0x100), a yaw rate (0x101) and a steering angle (0x102). Removed at the end, with the segment.
class Desk {
 public:
  Desk();

  [[nodiscard]] std::filesystem::path file(const std::string& name) const {
    return directory_ / name;
  }
  void write(const std::string& name, const std::string& text) const { scratch_.write(name, text); }
  [[nodiscard]] std::string read(const std::string& name) const { return contents(file(name)); }
  [[nodiscard]] const std::string& segment() const { return segment_; }
  /// Whether this text appears on the daemon's standard error.
  [[nodiscard]] ::testing::AssertionResult logs(const std::string& text) const;

  /// The status document from the status socket; null if there is none.
  [[nodiscard]] nlohmann::json status() const;

 private:
  Scratch scratch_;
  std::filesystem::path directory_ = std::filesystem::canonical(scratch_.path(""));
  std::string segment_ = directory_ / "pose";
};

struct Close {
  void operator()(odom_client* client) const { odom_close(client); }
  void operator()(odom_camera* camera) const { odom_camera_close(camera); }
};
using Client = std::unique_ptr<odom_client, Close>;
using Camera = std::unique_ptr<odom_camera, Close>;

/// Waits until the daemon exists.
[[nodiscard]] Client open_client(const Desk& desk);
[[nodiscard]] Camera open_camera(const Desk& desk);

/// Waits up to a second for the next pose.
[[nodiscard]] bool next_pose(const Client& client, odom_pose& pose);
/// Waits for a pose that fits.
[[nodiscard]] bool next_pose(const Client& client, odom_pose& pose,
                             const std::function<bool(const odom_pose&)>& fits);

/// Waits until the pose of an ended daemon is stale.
[[nodiscard]] bool becomes_stale(const Client& client, odom_pose& pose);

/// A straight drive at `speed` with frames every 10 ms, in the format of candump -L. Up to five
/// seconds fit into a pipe.
[[nodiscard]] std::string straight_drive(double seconds, double speed);

/// A program that runs beside the test. Its standard input is a pipe; its outputs are appended to a
/// file.
class Process {
 public:
  Process(std::vector<std::string> words, const std::vector<std::string>& more_words,
          const std::filesystem::path& outputs);
  ~Process();  ///< kills it if it is still running
  Process(const Process&) = delete;
  Process& operator=(const Process&) = delete;

  void feed(const std::string& text) const;
  void close_input();
  void signal(int number) const;
  /// Its exit status; -1 if a signal ended it, -2 if it does not end.
  [[nodiscard]] int wait();
  [[nodiscard]] pid_t pid() const { return pid_; }

 private:
  pid_t pid_ = -1;
  int input_ = -1;
};

/// odomd with the configuration of a desk, and the desk's file "stderr".
struct DaemonProcess : Process {
  DaemonProcess(const Desk& desk, const std::vector<std::string>& arguments)
      : Process({ODOMD_BIN_DIR "/odomd", "--config", desk.file("car.toml")}, arguments,
                desk.file("stderr")) {}
};

}  // namespace odomd::testing
