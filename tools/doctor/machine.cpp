#include "tools/diagnostics/kinds.hpp"
#include "tools/doctor/doctor.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <string_view>

namespace odomd::tools::doctor {
namespace {

using diagnostics::Kind;
using tools::kind;

// Whether reading the clock needs a system call or a slow device.
bool is_slow(std::string_view clock) {
  constexpr std::array<std::string_view, 6> slow{"hpet", "acpi_pm", "jiffies", "refined-jiffies",
                                                 "pit",  "xen"};
  return std::ranges::find(slow, clock) != slow.end();
}

struct Check {
  bool fails;
  const Kind* kind;
  std::string subject, seen, detail{};
};

}  // namespace

diagnostics::Diagnostics examine_machine(const Machine& machine, const Needs& needs) {
  constexpr const Kind &sleep = kind("cpus_sleep_deeply"), &throttled = kind("realtime_throttled"),
                       &full = kind("disk_nearly_full");
  const std::string& user = machine.user;
  const bool is_arm = machine.processor.starts_with("aarch64");
  // The service has its own limits, and a running daemon reports its rights.
  const bool user_limits_count = !needs.is_granted && !machine.has_service;
  const bool buffer_is_limited = machine.has_service || !machine.may_exceed_buffer;
  const Check checks[]{
      {!machine.is_realtime, &kind("no_realtime_kernel"), fmt::format("kernel {}", machine.kernel),
       "has no PREEMPT_RT, so a pose may come milliseconds late; this matters to a controller in a "
       "car, not at a desk",
       is_arm ? "linux-image-rt-arm64" : "linux-image-rt-amd64"},
      {machine.has_service && !machine.has_service_accounts, &kind("service_account_missing"),
       "odomd@.service", "its user odomd, or one of the groups odom and odomd-camera, is missing"},
      {machine.membership == Membership::none, &kind("not_in_group"), user,
       "is not in the group odom, which may read the pose", user},
      {machine.membership == Membership::later_login, &kind("login_before_group"), user,
       "is in the group odom, but not this login"},
      {user_limits_count && machine.priority_limit < needs.priority, &kind("no_realtime_priority"),
       user,
       fmt::format("may not use real-time priority {} (SCHED_FIFO{}), so other programs delay the "
                   "poses by milliseconds",
                   needs.priority,
                   machine.priority_limit == 0
                       ? ""
                       : fmt::format("; the limit is {}", machine.priority_limit)),
       fmt::format("{} - rtprio {}", user, needs.priority)},
      {user_limits_count && !machine.may_lock_memory, &kind("memory_not_locked"), user,
       "may not lock odomd's memory (memlock), so a tick may wait for the disk", user},
      {!needs.is_granted && !machine.may_hold_cpus_awake &&
           !sleep.limits.hold(machine.deepest_sleep_us),
       &sleep, "CPUs",
       fmt::format("wake {:.0f} µs late from their deepest sleep, and odomd may not open "
                   "/dev/cpu_dma_latency to prevent it",
                   machine.deepest_sleep_us),
       machine.has_service ? "odomd" : machine.group},
      {!throttled.limits.hold(machine.realtime_share), &throttled, "kernel",
       fmt::format("lets real-time threads run for at most {:.0f} % of the time",
                   100.0 * machine.realtime_share)},
      {is_slow(machine.clock), &kind("slow_clock"), "kernel",
       fmt::format("reads the time from {}, which takes microseconds", machine.clock),
       is_arm ? "arch_sys_counter" : "tsc"},
      {!machine.governor.empty(), &kind("cpu_frequency_changes"), "CPUs",
       fmt::format("have the frequency governor {}, not performance: a CPU that was idle starts "
                   "slowly, so ticks take longer",
                   machine.governor)},
      {buffer_is_limited && machine.largest_buffer < needs.receive_buffer,
       &kind("small_receive_buffer"), "net.core.rmem_max",
       fmt::format("is {} bytes, odomd asks for {}", machine.largest_buffer, needs.receive_buffer),
       std::to_string(needs.receive_buffer)},
      {!full.limits.hold(machine.free_gb), &full, machine.folder,
       fmt::format("{:.2f} GB are free for recordings", machine.free_gb)},
  };
  diagnostics::Diagnostics all;
  for (const auto& [fails, kind, subject, seen, detail] : checks)
    if (fails) all.push_back(diagnostics::found(*kind, subject, seen, detail));
  return all;
}

}  // namespace odomd::tools::doctor
