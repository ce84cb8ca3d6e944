// Start to end of the daemon: opens everything, starts the threads, keeps house, and takes it all
// down again.
#pragma once

#include <span>
#include <string>

#include "can_protocol/dbc/dbc.hpp"
#include "daemon/core/config.hpp"
#include "daemon/housekeeping/housekeeping.hpp"

namespace odomd::daemon {

/// Where the first pose comes from when a predecessor left one.
enum class Resume : std::uint8_t { allowed, forbidden };

struct RunSettings {
  AtEnd at_end = AtEnd::go_on;
  Resume resume = Resume::allowed;
};

/// Runs until TERM, INT or, if so wanted, the end of all inputs. Throws std::invalid_argument where
/// the configuration cannot be used, std::exception where this machine, as it is, does not let it.
/// Call it before any other thread is started: it sets what signals do (signals.hpp).
void run_daemon(const Config& config, std::span<const can::Database> databases,
                std::span<const std::string> warnings, const RunSettings& settings);

}  // namespace odomd::daemon
