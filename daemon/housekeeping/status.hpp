// The status document: all counters of the daemon as one JSON object. Built from counters and the
// published pose, without affecting the beat. docs/realtime.md describes its fields.
#pragma once

#include <cstdint>
#include <span>
#include <string>

#include <odom/odom.h>

#include "daemon/housekeeping/running.hpp"

namespace odomd::daemon {

/// The newest published pose, as a client would read it.
struct PublishedPose {
  bool valid = false;
  odom_pose pose{};
  odom_details details{};
};

[[nodiscard]] std::string status_json(const Running& running, const PublishedPose& published,
                                      std::int64_t now_ns);

/// The quantile [us] of a histogram: the upper edge of its bucket, at most `max_ns`. 0 without
/// samples.
[[nodiscard]] double percentile_us(std::span<const std::uint64_t, ODOM_HISTOGRAM_BUCKETS> histogram,
                                   double share, std::int64_t max_ns);

}  // namespace odomd::daemon
