// The machine that odomd runs on, or will run on: what makes a tick late, and who may read the
// pose.
#pragma once

#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "daemon/core/config.hpp"
#include "daemon/diagnostics/diagnostic.hpp"

namespace odomd::tools::doctor {

/// A thread of the kernel that takes a CAN controller's interrupt.
struct InterruptThread {
  std::string name;  ///< "irq/45-can0"
  int pid = 0;
  int priority = 0;  ///< of SCHED_FIFO
};

/// Of the user, to the group that may read the service's pose.
enum class Membership : std::uint8_t {
  not_needed,   ///< there is no such group, or root asks
  member,       ///< this login has it
  later_login,  ///< the user has it, this login is older
  none,
};

/// What read_machine() found; the defaults are those of a sound machine.
struct Machine {
  std::string kernel = "6.1.0-rt";  ///< its release
  std::string processor = "x86_64";
  bool is_realtime = true;  ///< PREEMPT_RT
  std::string user = "user";
  std::string group = "user";        ///< the user's own
  bool has_service = false;          ///< odomd@.service is installed
  bool has_service_accounts = true;  ///< its user and groups
  Membership membership = Membership::member;
  int priority_limit = 99;                ///< that this process may have of SCHED_FIFO
  bool may_lock_memory = true;            ///< this process, without limit
  bool may_hold_cpus_awake = true;        ///< this process; with a service: its group
  double deepest_sleep_us = 0.0;          ///< to wake from the deepest sleep state in use
  double realtime_share = 0.95;           ///< of the time, for real-time threads
  std::string clock = "tsc";              ///< source of the kernel's clock
  std::string governor;                   ///< of a CPU that changes its frequency; empty: none does
  bool may_exceed_buffer = false;         ///< CAP_NET_ADMIN
  std::int64_t largest_buffer = 1 << 20;  ///< net.core.rmem_max
  std::vector<InterruptThread> interrupts;
  std::string folder = ".";
  double free_gb = 100.0;  ///< in that folder
};

/// `root` is "/", or a copy of /etc, /proc and /sys for tests. What cannot be read is taken as
/// sound: a machine without cpufreq has no governor.
[[nodiscard]] Machine read_machine(const std::filesystem::path& root = "/");

/// What odomd asks of the machine.
struct Needs {
  int priority = daemon::RealtimeConfig{}.priority;
  int receive_buffer = daemon::CanConfig{}.receive_buffer;
  bool is_granted = false;  ///< a daemon runs, whose status says what it was granted
};

[[nodiscard]] diagnostics::Diagnostics examine_machine(const Machine& machine,
                                                       const Needs& needs = {});

}  // namespace odomd::tools::doctor
