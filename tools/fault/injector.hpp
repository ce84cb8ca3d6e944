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

/// One stream, one thread. Faults act one after the other, in the order of naming; those of the
/// camera are passed over.
class Injector {
 public:
  /// Throws std::invalid_argument where the configuration does not fit the databases, or a fault
  /// is of a source that it does not map: the message names the key.
  Injector(const daemon::Config& config, std::span<const can::Database> databases,
           std::span<const std::string> bus_names, std::span<const Fault> faults);

  /// From when the faults' times count; without it, from the first frame's stamp.
  void start(std::int64_t start_ns);

  /// Takes a frame and appends those that leave by then.
  void take(const can::Frame& frame, std::vector<can::Frame>& out);
  /// Appends what was held back until `now_ns`.
  void release(std::int64_t now_ns, std::vector<can::Frame>& out);

  /// The frames' faults, and how many frames each has acted on.
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

/// Throws std::invalid_argument where a fault is of a source that the configuration does not map.
void require_mapped(const daemon::Config& config, std::span<const Fault> faults);

}  // namespace odomd::fault
