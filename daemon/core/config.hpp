// The configuration: one TOML file, read once at start. Every number is SI; unknown keys, missing
// signals and impossible values are errors that name the file, the line and the nearest valid name.
#pragma once

#include <array>
#include <cstdint>
#include <filesystem>
#include <optional>
#include <stdexcept>
#include <string>
#include <string_view>
#include <vector>

#include "can_protocol/dbc/dbc.hpp"
#include "can_protocol/decode/signal_binding.hpp"
#include "daemon/diagnostics/diagnostic.hpp"
#include "estimator/common/estimate.hpp"
#include "estimator/common/measurement.hpp"
#include "estimator/common/settings.hpp"

namespace odomd::daemon {

/// An error in a configuration, as the one line that the user reads:
/// "car.toml:12: [vehicle] mas: unknown key; did you mean \"mass\"?"
class ConfigError : public std::invalid_argument {
 public:
  using std::invalid_argument::invalid_argument;
};

/// Settings of a role besides its binding.
struct SignalSettings {
  bool configured = false;
  double sigma = 0.0;           ///< standard deviation in the role's SI unit
  std::int64_t timeout_ns = 0;  ///< overdue after this time; default: three cycle times
  double dead_band = 0.0;       ///< of a wheel [m/s]; 0: learnt from the sensor's readings
};

enum class Timestamps : std::uint8_t { software, hardware };

struct CanConfig {
  std::vector<std::string> sources;          ///< interfaces, log files, "-"
  std::vector<std::filesystem::path> dbc;    ///< made absolute
  std::vector<can::SignalBinding> bindings;  ///< channel = estimator::Source
  std::vector<can::E2eBinding> protections;
  std::array<SignalSettings, estimator::source_count> signals{};
  Timestamps timestamps = Timestamps::software;
  int receive_buffer = 1 << 20;  ///< SO_RCVBUF in bytes
};

/// A socket that odomd makes for other programs.
struct SocketConfig {
  std::filesystem::path path;  ///< empty: set by place_sockets()
  std::uint32_t mode = 0660;
  std::string group;  ///< empty: the group of the process
};

struct CameraConfig {
  bool configured = false;
  SocketConfig socket;
  std::array<double, 3> lever_arm{};  ///< x, y [m], yaw [rad] of the reference point, body frame
  double max_latency_s = 0.2;
};

struct RealtimeConfig {
  std::int64_t period_ns = 5'000'000;
  int priority = 45;  ///< SCHED_FIFO
  int cpu = -1;       ///< pinned to this CPU; -1: any
};

struct ShmConfig {
  std::string name = "/odomd";
  std::uint32_t mode = 0644;
  std::string group;
};

struct LogConfig {
  std::filesystem::path file;  ///< empty: standard error
  std::string level = "info";
};

/// The range of [filter] window.
inline constexpr double shortest_window_s = 0.2;
inline constexpr double longest_window_s = 1.0;

struct Config {
  std::filesystem::path file;  ///< where the configuration was read from
  std::string text;            ///< the contents of `file`
  estimator::Vehicle vehicle;
  CanConfig can;
  CameraConfig camera;
  /// Like camera.lever_arm, for the point that a drive's truth.csv describes. Empty: the camera's.
  /// Not used by the daemon.
  std::optional<std::array<double, 3>> reference_lever_arm;
  std::array<double, 2> imu_position{};  ///< lever arm from the centre of gravity [m]
  double imu_yaw = 0.0;                  ///< of the accelerometer's x axis in the body frame [rad]
  /// Accelerometers roll and pitch with the body: measured a = (1 + gradient) a. Empty: learnt,
  /// starting at 0.
  std::optional<double> roll_gradient;
  std::optional<double> pitch_gradient;
  std::optional<estimator::Pose2> initial_pose;
  estimator::Model model = estimator::Model::full;
  double window_s = 0.25;  ///< history for late samples
  double camera_gate = estimator::FilterSettings{}.camera_gate;
  estimator::Tuning tuning;
  estimator::PaperNoise paper_noise;
  RealtimeConfig realtime;
  ShmConfig shm;
  SocketConfig status{.mode = 0666};
  SocketConfig record;  ///< where `odom record` connects; place_sockets() sets mode and group
  LogConfig log;
  diagnostics::Diagnostics warnings;  ///< about assumptions
};

[[nodiscard]] inline bool is_mapped(const Config& config, estimator::Source source) {
  return config.can.signals[estimator::index_of(source)].configured;
}
/// The signal that a source is mapped to; null: none.
[[nodiscard]] const can::SignalBinding* binding_of(const Config& config, estimator::Source source);

/// Reads and checks a file. Throws ConfigError (a std::invalid_argument) with one line: file, line,
/// key and fix. Does not open the databases.
[[nodiscard]] Config load_config(const std::filesystem::path& file);
/// The same for a text; `file` is the name in errors, and paths are relative to it.
[[nodiscard]] Config parse_config(std::string text, const std::filesystem::path& file);

/// Sets the paths of sockets that have none: the camera's and the status socket are in `directory`,
/// the recorders' socket is next to the status socket. Whoever may read the pose may also record it
/// with its inputs: call this when [shm] is final.
void place_sockets(Config& config, const std::filesystem::path& directory);

/// The model with this name; throws std::invalid_argument that lists the models.
[[nodiscard]] estimator::Model parse_model(std::string_view name);
[[nodiscard]] std::string_view name_of(estimator::Model model);

/// The first source that is named more than once: its frames would count twice.
[[nodiscard]] std::optional<std::string> named_twice(std::vector<std::string> sources);

/// The message for a pose that is not estimator::is_possible().
inline constexpr std::string_view pose_too_far =
    "is too far away; x and y must be within 1e8 m, yaw within 1e6 rad";

/// "x,y,yaw" in metres and radians, as on the command line; throws std::invalid_argument.
[[nodiscard]] estimator::Pose2 parse_pose(std::string_view text);

/// Reads the databases that a configuration names, and checks its bindings against them. Time-outs
/// that it does not set become three cycle times of the message (100 ms if the database has none).
/// Appends warnings about unusual content to `warnings`. Throws std::invalid_argument.
[[nodiscard]] std::vector<can::Database> load_databases(Config& config,
                                                        diagnostics::Diagnostics& warnings);

/// The buses that bindings refer to by name, in the order of their numbers in the decoder.
[[nodiscard]] std::vector<std::string> expected_buses(const Config& config);

/// Throws ConfigError when the model needs a role that is not mapped. load_databases() checks the
/// configured model, a Pipeline checks the model that it is given.
void require_roles(const Config& config);

/// The settings of the filter, except `initialise_from_camera`, which depends on the caller.
[[nodiscard]] estimator::FilterSettings filter_settings(const Config& config);

}  // namespace odomd::daemon
