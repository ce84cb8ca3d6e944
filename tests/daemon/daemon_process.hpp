// A running odomd for tests: its directory with configuration and database, its process, its
// status, and a client that reads its poses.
#pragma once

#include <filesystem>
#include <functional>
#include <memory>
#include <nlohmann/json.hpp>

#include <odom/odom.h>

#include "tests/gtest.hpp"
#include "tests/process.hpp"
#include "tests/scratch.hpp"

namespace odomd::testing {

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
  /// Waits for a status that satisfies the condition and returns it; otherwise the test fails.
  nlohmann::json await_status(const std::function<bool(nlohmann::json&)>& fits = [](auto&) {
    return true;
  }) const;

  /// Runs `odom ARGUMENTS` in the directory, with its output in the file `log`; returns its exit
  /// status.
  [[nodiscard]] int odom(const std::string& arguments, const std::string& log) const;

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
/// Waits for a pose that satisfies the condition.
[[nodiscard]] bool next_pose(const Client& client, odom_pose& pose,
                             const std::function<bool(const odom_pose&)>& fits);

/// Waits for a pose that satisfies the condition and returns it; otherwise the test fails.
odom_pose await_pose(
    const Client& client,
    const std::function<bool(const odom_pose&)>& fits = [](const odom_pose&) { return true; });

/// Waits until the pose of an ended daemon is stale.
[[nodiscard]] bool becomes_stale(const Client& client, odom_pose& pose);

/// A straight drive at `speed` with frames every 10 ms, in the format of candump -L. Up to five
/// seconds fit into a pipe.
[[nodiscard]] std::string straight_drive(double seconds, double speed);

/// odomd with the configuration of a desk; its outputs are appended to the desk's file "stderr".
struct DaemonProcess : Process {
  DaemonProcess(const Desk& desk, std::vector<std::string> arguments)
      : Process(words(desk, std::move(arguments)), desk.file("stderr"), desk.file("stderr")) {}

  /// Sends a signal and returns the exit status.
  int end_by(int number) {
    signal(number);
    return wait();
  }

 private:
  static std::vector<std::string> words(const Desk& desk, std::vector<std::string> arguments) {
    arguments.insert(arguments.begin(),
                     {ODOMD_BIN_DIR "/odomd", "--config", desk.file("car.toml")});
    return arguments;
  }
};

}  // namespace odomd::testing
