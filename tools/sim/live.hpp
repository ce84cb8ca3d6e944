// Plays a simulated drive in real time: frames to a CAN interface, or as candump lines to standard
// output, and camera poses to the daemon's socket.
#pragma once

#include <cstdint>
#include <filesystem>
#include <functional>
#include <span>
#include <string>

#include "base/file_descriptor.hpp"
#include "can_protocol/frame.hpp"
#include "tools/cli/output.hpp"
#include "tools/sim/drive_folder.hpp"
#include "tools/sim/simulation.hpp"

namespace odomd::sim {

class CanOutput {
 public:
  /// `name` is an interface, or "-" for standard output. Throws std::invalid_argument if there is
  /// no such interface, std::runtime_error if it cannot be opened.
  explicit CanOutput(const std::string& name);

  /// Sends all frames immediately. Throws std::runtime_error if they cannot be sent: nobody reads
  /// or acknowledges, or the interface is down.
  void send(std::span<const can::Frame> frames);

 private:
  void transmit(const can::Frame& frame);

  std::string name_;
  FileDescriptor socket_;  // not open for standard output
  std::string text_;
};

struct LiveOptions {
  std::int64_t start_ns = 0;            ///< start_ns of the simulation's plan: live_start_ns()
  std::string can = "-";                ///< interface, or "-" for standard output
  std::filesystem::path camera_socket;  ///< empty: no camera
};

enum class LiveEnd : std::uint8_t { drive_over, interrupted };

struct LiveSummary {
  LiveEnd end = LiveEnd::drive_over;
  std::uint64_t camera_sent = 0;
  std::uint64_t camera_dropped = 0;  ///< the daemon was not running, or did not keep up
};

/// "12.3 s, 8.1 of 82.2 m (10 %), 1.50 m/s"
[[nodiscard]] std::string progress_text(const Simulation& simulation);

/// The start of a live drive: a tick of CLOCK_REALTIME in the near future, by which all is set up.
/// From then on stamps advance exactly with simulated time.
[[nodiscard]] std::int64_t live_start_ns();

/// Sends frames and poses at their times, or immediately if late. Returns at the end of the drive,
/// or on SIGINT or SIGTERM. Calls `also` with all that was sent, stretch by stretch. Throws like
/// CanOutput; from then on a closed pipe is such an error and no longer raises SIGPIPE. The
/// camera's socket may come and go.
LiveSummary play_live(Simulation& simulation, const LiveOptions& options,
                      tools::ProgressLine& progress,
                      const std::function<void(const Happenings&)>& also);

}  // namespace odomd::sim
