#include "daemon/realtime/privileges.hpp"

#include <fcntl.h>
#include <linux/capability.h>
#include <pthread.h>
#include <sched.h>
#include <sys/mman.h>
#include <sys/resource.h>
#include <sys/syscall.h>
#include <unistd.h>

#include <array>
#include <cerrno>
#include <cstdint>
#include <cstring>

#include <fmt/format.h>

namespace odomd::daemon {
namespace {

constexpr std::size_t stack_size = std::size_t{1} << 20;      // of each thread, and locked
constexpr std::size_t stack_in_use = std::size_t{256} << 10;  // far more than a tick needs

bool has_capability(std::uint32_t capability) {
  __user_cap_header_struct header{_LINUX_CAPABILITY_VERSION_3, 0};
  std::array<__user_cap_data_struct, 2> data{};
  if (::syscall(SYS_capget, &header, data.data()) != 0) return false;
  return (data[capability / 32].effective >> (capability % 32) & 1U) != 0;
}

/// With a finite limit a later allocation would fail, so do not lock at all.
bool may_lock_everything() {
  if (has_capability(CAP_IPC_LOCK)) return true;
  const rlimit unlimited{RLIM_INFINITY, RLIM_INFINITY};
  ::setrlimit(RLIMIT_MEMLOCK, &unlimited);
  rlimit limit{};
  return ::getrlimit(RLIMIT_MEMLOCK, &limit) == 0 && limit.rlim_cur == RLIM_INFINITY;
}

void lock_memory(MachineGrant& grant) {
  if (!may_lock_everything()) {
    grant.refusals.emplace_back(
        "memory is not locked: the memlock limit is finite; set LimitMEMLOCK=infinity or grant "
        "CAP_IPC_LOCK");
  } else if (::mlockall(MCL_CURRENT | MCL_FUTURE) != 0) {
    grant.refusals.push_back(
        fmt::format("memory is not locked: {}; set LimitMEMLOCK=infinity or grant CAP_IPC_LOCK",
                    std::strerror(errno)));
  } else {
    grant.memory_locked = true;
  }
}

void hold_dma_latency(MachineGrant& grant) {
  constexpr auto device = "/dev/cpu_dma_latency";
  grant.dma_latency = FileDescriptor(::open(device, O_RDWR | O_CLOEXEC));
  constexpr std::int32_t microseconds = 0;
  if (!grant.dma_latency ||
      ::write(grant.dma_latency.get(), &microseconds, sizeof microseconds) != sizeof microseconds) {
    grant.refusals.push_back(
        fmt::format("CPUs may enter deep sleep: {}: {}; grant access to the device", device,
                    std::strerror(errno)));
    grant.dma_latency = {};
  }
}

__attribute__((noinline)) void touch_stack() noexcept {
  std::array<volatile std::uint8_t, stack_in_use> stack;
  constexpr std::size_t page = 4096;
  for (std::size_t i = 0; i < stack.size(); i += page) stack[i] = 1;
}

}  // namespace

MachineGrant prepare_machine() {
  pthread_attr_t attributes;
  if (::pthread_attr_init(&attributes) == 0) {
    ::pthread_attr_setstacksize(&attributes, stack_size);
    ::pthread_setattr_default_np(&attributes);
    ::pthread_attr_destroy(&attributes);
  }
  MachineGrant grant;
  lock_memory(grant);
  hold_dma_latency(grant);
  return grant;
}

ThreadGrant become_realtime(int priority, int cpu, const char* name) {
  ThreadGrant grant;
  const pthread_t self = ::pthread_self();
  ::pthread_setname_np(self, name);
  if (cpu >= 0) {
    cpu_set_t set;
    CPU_ZERO(&set);
    CPU_SET(static_cast<std::size_t>(cpu), &set);
    if (const int error = ::pthread_setaffinity_np(self, sizeof set, &set); error == 0) {
      grant.cpu = cpu;
    } else {
      grant.refusals.push_back(
          fmt::format("thread {} is not pinned to CPU {}: {}; set [realtime] cpu to one that "
                      "exists and is allowed",
                      name, cpu, std::strerror(error)));
    }
  }
  const sched_param parameters{.sched_priority = priority};
  if (const int error = ::pthread_setschedparam(self, SCHED_FIFO, &parameters); error == 0) {
    grant.priority = priority;
  } else {
    grant.refusals.push_back(
        fmt::format("thread {} has no real-time scheduling (SCHED_FIFO {}): {}; set LimitRTPRIO={} "
                    "or grant CAP_SYS_NICE",
                    name, priority, std::strerror(error), priority));
  }
  touch_stack();
  return grant;
}

}  // namespace odomd::daemon
