// What odomd does with its configuration: runs the daemon from start to end (opens everything,
// starts the threads, does the housekeeping, and shuts down), or shows what it makes of it.
#pragma once

#include <span>
#include <string>

#include "can_protocol/dbc/dbc.hpp"
#include "daemon/core/config.hpp"
#include "daemon/diagnostics/diagnostic.hpp"
#include "daemon/housekeeping/housekeeping.hpp"

namespace odomd::daemon {

/// Whether the pose may start from the last pose of a predecessor.
enum class Resume : std::uint8_t { allowed, forbidden };

struct RunSettings {
  AtEnd at_end = AtEnd::go_on;
  Resume resume = Resume::allowed;
};

/// Runs until TERM, INT or, if requested, the end of all inputs. Throws std::invalid_argument when
/// the configuration is not usable, std::exception when this machine does not allow it. Call it
/// before any other thread is started: it sets up the signals (process_control.hpp).
void run_daemon(const Config& config, std::span<const can::Database> databases,
                const diagnostics::Diagnostics& warnings, const RunSettings& settings);

/// `odomd --check` (check.cpp): the summary of a configuration that has been checked against its
/// databases. Throws std::invalid_argument when a source is not usable.
[[nodiscard]] std::string summary(const Config& config, std::span<const can::Database> databases,
                                  const diagnostics::Diagnostics& warnings);

}  // namespace odomd::daemon
