// What is asked of the machine for the beat's sake, and what it granted. Nothing here is fatal: a
// refusal is remembered in words, and the daemon goes on and publishes that it is not real time.
#pragma once

#include <string>
#include <vector>

#include "base/file_descriptor.hpp"
#include "daemon/core/config.hpp"

namespace odomd::daemon {

/// What the process holds. Kept alive as long as the beat runs.
struct MachineGrant {
  bool memory_locked = false;
  FileDescriptor dma_latency;         ///< /dev/cpu_dma_latency, held: no deep sleep of the CPUs
  std::vector<std::string> refusals;  ///< one line each, with the mend
};

/// Locks the memory, present and future, and keeps the CPUs out of deep sleep. Call before the
/// threads are made: it also sets their stacks to a size that is worth locking.
[[nodiscard]] MachineGrant prepare_machine();

/// What a thread got.
struct ThreadGrant {
  int priority = 0;  ///< of SCHED_FIFO; 0: ordinary scheduling
  int cpu = -1;      ///< pinned to it; -1: to none
  std::vector<std::string> refusals;
};

/// Schedules the calling thread by SCHED_FIFO, pins it (cpu >= 0), and touches its stack, so that
/// no tick meets a page for the first time.
[[nodiscard]] ThreadGrant become_realtime(int priority, int cpu, const char* name);

}  // namespace odomd::daemon
