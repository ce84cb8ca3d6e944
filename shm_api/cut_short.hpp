// A segment that is cut short (truncate(1), by its owner) takes the memory away under those who
// have mapped it: their next access is a SIGBUS. Programs of ours end with one line then.
#pragma once

#include <csignal>

namespace odomd::shm {

/// Ends this process with one line on standard error and status 1 where the memory behind a mapping
/// is gone. `program`, which outlives the process, begins the line.
void end_where_a_segment_is_cut_short(const char* program);

/// For handlers of SIGBUS with more to do: says the line and ends, where `info` tells of that
/// cause; else returns. Async-signal-safe.
void end_if_cut_short(const siginfo_t& info) noexcept;

}  // namespace odomd::shm
