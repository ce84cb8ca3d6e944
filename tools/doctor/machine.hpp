// Examines the machine that odomd runs on, or will run on, for causes of late ticks and for the
// right to read the pose; and a running daemon by its status.
#pragma once

#include <cstdint>
#include <filesystem>
#include <nlohmann/json_fwd.hpp>
#include <optional>
#include <string>

#include "daemon/core/config.hpp"
#include "daemon/diagnostics/diagnostic.hpp"

namespace odomd::tools::doctor {

/// The user's membership in the group that may read the service's pose.
enum class Membership : std::uint8_t {
  not_needed,   ///< there is no such group, or the user is root
  member,       ///< this login is in the group
  later_login,  ///< the user is in the group, but this login is older
  none,
};

/// The machine as read by read_machine(); the defaults are those of a sound machine.
struct Machine {
  std::string kernel = "6.1.0-rt";  ///< its release
  std::string processor = "x86_64";
  bool is_realtime = true;  ///< PREEMPT_RT
  std::string user = "user";
  std::string group = "user";        ///< the user's primary group
  bool has_service = false;          ///< odomd@.service is installed
  bool has_service_accounts = true;  ///< the service's user and groups exist
  Membership membership = Membership::member;
  int priority_limit = 99;                ///< highest SCHED_FIFO priority of this process
  bool may_lock_memory = true;            ///< this process, without limit
  bool may_hold_cpus_awake = true;        ///< this process; with a service: the service's group
  double deepest_sleep_us = 0.0;          ///< wake-up latency of the deepest sleep state in use
  double realtime_share = 0.95;           ///< share of the time for real-time threads
  std::string clock = "tsc";              ///< the kernel's clock source
  std::string governor;                   ///< of a CPU that changes its frequency; empty: none
  bool may_exceed_buffer = false;         ///< CAP_NET_ADMIN
  std::int64_t largest_buffer = 1 << 20;  ///< net.core.rmem_max
  std::string folder = ".";
  double free_gb = 100.0;  ///< free space in `folder`
};

/// `root` is "/", or in tests a folder with copies of /etc, /proc and /sys. Missing entries are no
/// fault: a machine without cpufreq has no governor.
[[nodiscard]] Machine read_machine(const std::filesystem::path& root = "/");

/// odomd's requirements on the machine.
struct Needs {
  int priority = daemon::RealtimeConfig{}.priority;
  int receive_buffer = daemon::CanConfig{}.receive_buffer;
  bool is_granted = false;  ///< a daemon runs, whose status reports its rights
};

[[nodiscard]] diagnostics::Diagnostics examine_machine(const Machine& machine,
                                                       const Needs& needs = {});

/// Examines a running daemon: rights that the machine refused, its beat, buses, sources and camera.
/// `status` is the document of the status socket; `machine` has the user whose limits to raise.
/// Causes are reported without their consequences: a beat without real-time priority is not called
/// late, a signal of a silent bus not overdue. examine_link() (bus.hpp) examines the interfaces.
/// Throws a nlohmann::json::exception if a member has the wrong type.
[[nodiscard]] diagnostics::Diagnostics examine_daemon(const nlohmann::json& status,
                                                      const Machine& machine);

}  // namespace odomd::tools::doctor
