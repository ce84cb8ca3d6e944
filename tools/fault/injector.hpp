// Several faults at once in a stream of frames.
//
//   Injector injector(config, databases, bus_names, faults);
//   injector.take(frame, out);  // out: what leaves by now
//   injector.release(all_of_them, out);
#pragma once

#include <cstdint>
#include <limits>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "can_protocol/dbc/dbc.hpp"
#include "daemon/core/config.hpp"
#include "tools/fault/frame_fault.hpp"

namespace odomd::fault {

inline constexpr std::int64_t end_of_time = std::numeric_limits<std::int64_t>::max();

/// One stream, one thread. Faults act one after the other, in the order given; those of the camera
/// are ignored.
class Injector {
 public:
  /// Throws std::invalid_argument if the configuration does not fit the databases, or does not map
  /// the source of a fault: the message names the key.
  Injector(const daemon::Config& config, std::span<const can::Database> databases,
           std::span<const std::string> bus_names, std::span<const Fault> faults);

  /// The time from which the faults' times count; by default the first frame's stamp.
  void start(std::int64_t start_ns);

  /// Takes a frame and appends those that are output by then.
  void take(const can::Frame& frame, std::vector<can::Frame>& out);
  /// Appends the frames held back until `now_ns`.
  void release(std::int64_t now_ns, std::vector<can::Frame>& out);

  /// The faults of frames, and the number of frames that each affected.
  struct Acted {
    Fault fault;
    std::uint64_t frames = 0;
  };
  [[nodiscard]] std::vector<Acted> acted() const;

 private:
  void pass(std::size_t stage, std::vector<can::Frame>& out);

  CarSignals signals_;
  std::vector<Fault> faults_;
  std::array<double, estimator::source_count> sigma_{};
  std::vector<FrameFault> stages_;
  std::vector<can::Frame> in_, next_;
  bool started_ = false;
};

/// Throws std::invalid_argument if the configuration does not map the source of a fault.
void require_mapped(const daemon::Config& config, std::span<const Fault> faults);

}  // namespace odomd::fault
