// When a segment is truncated (truncate(1), by its owner), the next access of a process that has
// mapped it raises SIGBUS. Our programs then end with a one-line message.
#pragma once

#include <csignal>

namespace odomd::shm {

/// Ends this process with one line on standard error and status 1 when the memory behind a mapping
/// is gone. The line begins with `program`, which must never be freed.
void end_where_a_segment_is_cut_short(const char* program);

/// For SIGBUS handlers that have other tasks, too: if `info` says that a mapping was truncated,
/// writes the line and ends the process; otherwise returns. Async-signal-safe.
void end_if_cut_short(const siginfo_t& info) noexcept;

}  // namespace odomd::shm
