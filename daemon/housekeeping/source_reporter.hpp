// Logs changes of the inputs: buses that go down and come back, controllers with errors, signals
// that do not arrive, frames that the kernel dropped. Compares the current state with that of the
// last call.
#pragma once

#include <array>
#include <cstdint>
#include <string>
#include <vector>

#include "daemon/core/wiring.hpp"
#include "daemon/housekeeping/controllers.hpp"
#include "daemon/housekeeping/running.hpp"
#include "daemon/housekeeping/status.hpp"
#include "daemon/journal/journal.hpp"

namespace odomd::daemon {

class SourceReporter {
 public:
  explicit SourceReporter(const Running& running);

  /// Logs what has changed since the last call. Not real-time.
  void update(const PublishedPose& published, std::int64_t now_ns, Journal& journal);

 private:
  void check_links(std::int64_t now_ns, Journal& journal);
  void check_controller(std::size_t index, std::int64_t now_ns, Journal& journal);
  void check_signals(const PublishedPose& published, std::int64_t now_ns, Journal& journal);
  void check_camera_times(Journal& journal);
  void check_wiring(Journal& journal);
  void check_learning(const odom_pose& pose, Journal& journal);

  /// A signal that was never received is reported after this time.
  static constexpr std::int64_t first_sample_timeout_ns = 2'000'000'000;

  struct Bus {
    can::LinkState link = can::LinkState::up;
    std::uint64_t lost = 0;
    std::uint64_t link_downs = 0;
    std::uint64_t error_frames = 0;
    std::uint64_t bus_offs = 0;      ///< reported ones, by error frames
    std::int64_t bus_off_ns = 0;     ///< the first one that is not reported yet; 0: none
    std::int64_t controller_ns = 0;  ///< of the last report on the controller
    can::ControllerHealth controller = can::ControllerHealth::error_active;
    std::size_t warnings_logged = 0;
  };
  /// The number of camera poses per check.
  static constexpr std::uint64_t enough_poses = 10;
  /// The counts at the last check.
  struct CameraTimes {
    std::uint64_t all = 0;
    std::uint64_t future = 0;
    bool reported = false;
  };
  enum class Signal : std::uint8_t { awaited, healthy, unhealthy };

  const Running& running_;
  std::vector<Bus> buses_;
  std::array<Signal, estimator::source_count> signals_{};
  std::array<WiringFault, estimator::source_count> wiring_{};
  std::array<bool, estimator::source_count> inconsistent_{};
  bool bias_unlearnt_ = false;
  bool scale_implausible_ = false;
  CameraTimes camera_;
};

}  // namespace odomd::daemon
