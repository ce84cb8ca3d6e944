// The observed state of a daemon.
#pragma once

#include <odom/types.h>

#include <cstdint>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>

#include "tools/live/watch/trail.hpp"

namespace odomd::watch {

/// What the shared memory says.
struct Segment {
  odom_pose pose{};
  odom_details details{};
  odom_info info{};
  odom_beat beat{};
  bool silent = false;  ///< the daemon has not ticked for four periods; this is its last state
};

struct State {
  std::int64_t now_ns = 0;  ///< CLOCK_MONOTONIC

  std::string segment_name;        ///< as it was asked for
  std::optional<Segment> segment;  ///< absent: never attached, or nothing published yet
  std::string segment_problem;     ///< why it is absent; empty: as the status is, which names it
  Trail trail;

  std::string socket;
  std::optional<nlohmann::json> status;  ///< the newest document, absent while nobody answers
  std::optional<nlohmann::json> before;  ///< one some seconds earlier, for rates
  std::string status_problem;            ///< why it is absent

  std::uint64_t restarts = 0;  ///< times another daemon took over while we watched
};

}  // namespace odomd::watch
