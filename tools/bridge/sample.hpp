// What the bridge passes to its sinks.
#pragma once

#include <cstdint>
#include <string>

#include <odom/types.h>

namespace odomd::tools {

/// A published pose. The details are of the same tick, or of the newest one if the bridge fell
/// behind and fetched the pose from the history, which keeps no details.
struct BridgeSample {
  odom_pose pose{};
  odom_details details{};
  std::int64_t realtime_ns = 0;  ///< when the pose is valid, CLOCK_REALTIME
};

/// Sends samples. One thread.
class Sink {
 public:
  Sink() = default;
  Sink(const Sink&) = delete;
  Sink& operator=(const Sink&) = delete;
  virtual ~Sink() = default;

  /// Never blocks for longer than a few milliseconds; what cannot be sent is counted.
  virtual void send(const BridgeSample& sample) = 0;

  struct Counts {
    std::uint64_t sent = 0;
    std::uint64_t dropped = 0;  ///< could not be sent
    std::uint64_t withheld =
        0;  ///< poses in the mode fault that were not sent, as the format has no modes
  };
  [[nodiscard]] const Counts& counts() const { return counts_; }
  [[nodiscard]] const std::string& name() const { return name_; }

 protected:
  Counts counts_;
  std::string name_;  ///< for people
};

}  // namespace odomd::tools
