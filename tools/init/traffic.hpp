// Signal candidates in a log or on a live bus: their series and message intervals.
#pragma once

#include <cstdint>
#include <map>
#include <span>
#include <string>
#include <vector>

#include "can_protocol/dbc/dbc.hpp"
#include "can_protocol/frame.hpp"
#include "tools/identify/common/signal_log.hpp"
#include "tools/init/roles.hpp"

namespace odomd::tools {

/// The frames of a drive, and the names of their buses.
struct Traffic {
  std::string name;  ///< "drive.log", "can0"
  std::vector<can::Frame> frames;
  std::vector<std::string> buses;
  std::vector<std::string> warnings;  ///< about the logs

  [[nodiscard]] bool empty() const { return frames.empty(); }
};

/// All frames of logs, merged by stamp. Throws like can::MergedLog: file, line, fix.
[[nodiscard]] Traffic read_logs(std::span<const std::string> logs, can::Damage damage);

/// Listens to an interface for this time [s], or until INT. Throws std::invalid_argument if no
/// frame arrived.
[[nodiscard]] Traffic listen(const std::string& interface, double seconds);

/// How often a message is sent, and on which buses.
struct Rhythm {
  double cycle = 0.0;              ///< median time between frames [s]
  double longest = 0.0;            ///< 99.9 % of these times are shorter [s]
  std::vector<std::string> buses;  ///< the buses that carry it, the busiest first
};

/// The rhythms of those messages of the databases that arrived, by can::frame_key.
[[nodiscard]] std::map<std::uint32_t, Rhythm> rhythms(const Traffic& traffic,
                                                      std::span<const can::Database> databases);

/// The valid values of a candidate in SI units, as the daemon decodes them, with fraction and sign.
/// Settles the conditions of the candidate.
[[nodiscard]] Series series_of(const Traffic& traffic, std::span<const can::Database> databases,
                               Candidate& candidate);

}  // namespace odomd::tools
