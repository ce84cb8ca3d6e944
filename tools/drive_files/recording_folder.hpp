// Writes a recording: a folder of logs for `odom replay`. docs/recording.md has the formats.
#pragma once

#include <array>
#include <cstdint>
#include <filesystem>
#include <nlohmann/json.hpp>
#include <span>
#include <string>
#include <vector>

#include "base/file_descriptor.hpp"
#include "daemon/core/recording_tap.hpp"
#include "daemon/core/recording_wire.hpp"

namespace odomd::tools {

// The names of the files in the folder.
inline constexpr const char* recorded_frames = "can.log";
inline constexpr const char* recorded_cameras = "camera.csv";
inline constexpr const char* recorded_beat = "beat.csv";
inline constexpr const char* recorded_poses = "pose.csv";
inline constexpr const char* recorded_info = "info.json";
inline constexpr const char* recorded_state = "state.bin";
inline constexpr const char* recorded_config = "car.toml";

/// The version of the folder's formats.
inline constexpr int recording_format = 1;

/// The data that odomd sends before its ticks.
struct RecordingStart {
  nlohmann::ordered_json hello;
  std::vector<daemon::RecordingFile> files;
  std::vector<std::string> buses;
  std::string state;
};

/// A file that only grows. Throws std::runtime_error that names it if it cannot be written.
class GrowingFile {
 public:
  explicit GrowingFile(std::filesystem::path path);

  [[nodiscard]] std::string& text() { return text_; }  ///< to append to
  void write();                                        ///< passes the appended text to the system
  void sync();                                         ///< writes the file to the disk
  [[nodiscard]] std::uint64_t bytes() const { return bytes_ + text_.size(); }

 private:
  std::filesystem::path path_;
  FileDescriptor file_;
  std::string text_;
  std::uint64_t bytes_ = 0;
};

struct RecordingCounts {
  std::uint64_t ticks = 0;  ///< recorded, except the first, whose state starts a replay
  std::uint64_t frames = 0;
  std::uint64_t cameras = 0;
  std::uint64_t unusable_cameras = 0;  ///< messages that are not a pose
  std::uint64_t first_tick = 0;        ///< its number
  std::uint64_t last_tick = 0;         ///< number of the newest tick
};

/// One recording. Throws std::invalid_argument if the folder exists, std::runtime_error if it
/// cannot be written.
class RecordingFolder {
 public:
  RecordingFolder(std::filesystem::path folder, RecordingStart start);

  void set_buses(std::vector<std::string> names);
  void take(const daemon::TickMark& mark, std::span<const can::Frame> frames,
            std::span<const estimator::CameraPose> cameras);

  /// Writes everything to the disk, the ticks after their inputs, so that every tick on the disk
  /// has its inputs, even if the machine fails.
  void flush();

  /// Ends the recording; `why` is written to info.json.
  void close(const std::string& why);

  [[nodiscard]] const RecordingCounts& counts() const { return counts_; }
  [[nodiscard]] std::uint64_t bytes() const;
  [[nodiscard]] const std::filesystem::path& path() const { return folder_; }

 private:
  void begin(const daemon::TickMark& mark);
  void write_info(const std::string& end);

  std::filesystem::path folder_;
  RecordingStart start_;
  std::int64_t clock_offset_ns_ = 0;  // the recording's clock - CLOCK_MONOTONIC
  std::string started_;               // date and time
  nlohmann::ordered_json initial_;    // pose of the first tick
  RecordingCounts counts_;
  GrowingFile frames_;
  GrowingFile cameras_;
  GrowingFile beat_;
  GrowingFile poses_;
};

}  // namespace odomd::tools
