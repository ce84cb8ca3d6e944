// Requests real-time privileges from the machine and records what it granted. Nothing here is
// fatal: refusals are kept as text, and the daemon continues and publishes that it is not real
// time.
#pragma once

#include <string>
#include <vector>

#include "base/file_descriptor.hpp"
#include "daemon/core/config.hpp"

namespace odomd::daemon {

/// The privileges of the process. Must live as long as the beat runs.
struct MachineGrant {
  bool memory_locked = false;
  FileDescriptor dma_latency;  ///< /dev/cpu_dma_latency, kept open: prevents deep sleep of the CPUs
  std::vector<std::string> refusals;  ///< one line each, with the fix; finally also the threads'
};

/// Locks present and future memory, and keeps the CPUs out of deep sleep. Call before threads are
/// created: it also limits their stack size, since stacks are locked too.
[[nodiscard]] MachineGrant prepare_machine();

/// The privileges of a thread.
struct ThreadGrant {
  int priority = 0;  ///< of SCHED_FIFO; 0: ordinary scheduling
  int cpu = -1;      ///< pinned to this CPU; -1: not pinned
  std::vector<std::string> refusals;
};

/// Schedules the calling thread by SCHED_FIFO, pins it (cpu >= 0), and touches its stack, so that
/// no tick causes a page fault.
[[nodiscard]] ThreadGrant become_realtime(int priority, int cpu, const char* name);

}  // namespace odomd::daemon
