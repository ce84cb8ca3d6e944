// What the bridge hands to those who send it on.
#pragma once

#include <cstdint>
#include <string>

#include <odom/types.h>

namespace odomd::tools {

/// A published pose. The details are of the same tick, or of the newest where the bridge fell
/// behind and had the pose from the history, which keeps no details for it.
struct BridgeSample {
  odom_pose pose{};
  odom_details details{};
  std::int64_t realtime_ns = 0;  ///< when the pose is valid, CLOCK_REALTIME
};

/// Somebody to send samples to. One thread.
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
    std::uint64_t dropped = 0;   ///< could not be sent
    std::uint64_t withheld = 0;  ///< not sent: a pose in the mode fault, to those who know no modes
  };
  [[nodiscard]] const Counts& counts() const { return counts_; }
  [[nodiscard]] const std::string& name() const { return name_; }

 protected:
  Counts counts_;
  std::string name_;  ///< for people
};

}  // namespace odomd::tools
