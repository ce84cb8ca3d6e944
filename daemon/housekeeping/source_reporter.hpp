// Says in words what changes about the inputs: buses that go down and come back, controllers that
// meet errors, signals that fail to appear, frames that the kernel dropped. Compares what it sees
// with what it saw the last time.
#pragma once

#include <array>
#include <cstdint>
#include <string>
#include <vector>

#include "daemon/housekeeping/controller_news.hpp"
#include "daemon/housekeeping/running.hpp"
#include "daemon/housekeeping/status.hpp"
#include "daemon/journal/journal.hpp"

namespace odomd::daemon {

class SourceReporter {
 public:
  explicit SourceReporter(const Running& running);

  void look(const PublishedPose& published, std::int64_t now_ns, Journal& journal);

 private:
  void look_at_links(std::int64_t now_ns, Journal& journal);
  void look_at_controller(std::size_t bus, std::int64_t now_ns, Journal& journal);
  void look_at_signals(const PublishedPose& published, std::int64_t now_ns, Journal& journal);
  void look_at_camera_times(Journal& journal);
  void look_at_wiring(Journal& journal);

  /// A signal that never came is spoken of after so long.
  static constexpr std::int64_t patience_ns = 2'000'000'000;

  struct Bus {
    can::LinkState link = can::LinkState::up;
    std::uint64_t lost = 0;
    std::uint64_t link_downs = 0;
    std::uint64_t error_frames = 0;
    std::uint64_t bus_offs = 0;
    ControllerNews controller;
    std::size_t complaints_told = 0;
  };
  /// Of the camera's poses so many are looked at together.
  static constexpr std::uint64_t enough_poses = 10;
  /// What was counted when they were looked at last.
  struct CameraTimes {
    std::uint64_t future = 0;
    std::uint64_t in_time = 0;
    bool told = false;
  };
  enum class Signal : std::uint8_t { waited_for, healthy, unhealthy };

  const Running& running_;
  std::vector<Bus> buses_;
  std::array<Signal, estimator::source_count> signals_{};
  std::array<WiringFault, estimator::source_count> wiring_{};
  std::array<bool, estimator::source_count> inconsistent_{};
  CameraTimes camera_;
};

}  // namespace odomd::daemon
