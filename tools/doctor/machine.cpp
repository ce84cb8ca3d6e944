#include "tools/doctor/machine.hpp"
#include "tools/diagnostics/kinds.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <string_view>

namespace odomd::tools::doctor {
namespace {

using diagnostics::Diagnostics;
using diagnostics::found;
using diagnostics::Kind;
using tools::kind;

// Threaded interrupts have this priority unless somebody changes it.
constexpr int usual_interrupt_priority = 50;

bool is_arm(const Machine& machine) {
  return machine.processor.starts_with("aarch64");
}

// Whether reading the clock takes a system call or a slow device.
bool is_slow(std::string_view clock) {
  constexpr std::array<std::string_view, 6> slow{"hpet", "acpi_pm", "jiffies", "refined-jiffies",
                                                 "pit",  "xen"};
  return std::ranges::find(slow, clock) != slow.end();
}

// Checks permissions. The service has its own limits, and a running daemon reports its rights.
void examine_rights(const Machine& machine, const Needs& needs, Diagnostics& all) {
  if (machine.has_service && !machine.has_service_accounts)
    all.push_back(found(kind("service_account_missing"), "odomd@.service",
                        "its user odomd, or one of the groups odom and odomd-camera, is missing"));
  if (machine.membership == Membership::none)
    all.push_back(found(kind("not_in_group"), machine.user,
                        "is not in the group odom, which may read the pose", machine.user));
  if (machine.membership == Membership::later_login)
    all.push_back(found(kind("login_before_group"), machine.user,
                        "is in the group odom, but not this login"));
  if (needs.is_granted || machine.has_service) return;
  if (machine.priority_limit < needs.priority)
    all.push_back(found(kind("no_realtime_priority"), machine.user,
                        fmt::format("may not use real-time priority {} (SCHED_FIFO{}), so other "
                                    "programs delay the poses by milliseconds",
                                    needs.priority,
                                    machine.priority_limit == 0
                                        ? ""
                                        : fmt::format("; the limit is {}", machine.priority_limit)),
                        fmt::format("{} - rtprio {}", machine.user, needs.priority)));
  if (!machine.may_lock_memory)
    all.push_back(found(kind("memory_not_locked"), machine.user,
                        "may not lock odomd's memory (memlock), so a tick may wait for the disk",
                        machine.user));
}

void examine_cpus(const Machine& machine, const Needs& needs, Diagnostics& all) {
  constexpr const Kind& sleep = kind("cpus_sleep_deeply");
  if (!needs.is_granted && !machine.may_hold_cpus_awake &&
      !sleep.limits.hold(machine.deepest_sleep_us))
    all.push_back(
        found(sleep, "CPUs",
              fmt::format("wake {:.0f} µs late from their deepest sleep, and odomd may not open "
                          "/dev/cpu_dma_latency to prevent it",
                          machine.deepest_sleep_us),
              machine.has_service ? "odomd" : machine.group));
  constexpr const Kind& throttled = kind("realtime_throttled");
  if (!throttled.limits.hold(machine.realtime_share))
    all.push_back(found(throttled, "kernel",
                        fmt::format("lets real-time threads run for at most {:.0f} % of the time",
                                    100.0 * machine.realtime_share)));
  if (is_slow(machine.clock))
    all.push_back(
        found(kind("slow_clock"), "kernel",
              fmt::format("reads the time from {}, which takes microseconds", machine.clock),
              is_arm(machine) ? "arch_sys_counter" : "tsc"));
  if (!machine.governor.empty())
    all.push_back(
        found(kind("cpu_frequency_changes"), "CPUs",
              fmt::format("have the frequency governor {}, not performance: a CPU that was idle "
                          "starts slowly, so ticks take longer",
                          machine.governor)));
}

}  // namespace

Diagnostics examine_machine(const Machine& machine, const Needs& needs) {
  Diagnostics all;
  if (!machine.is_realtime)
    all.push_back(
        found(kind("no_realtime_kernel"), fmt::format("kernel {}", machine.kernel),
              "has no PREEMPT_RT, so a pose may come milliseconds late; this matters to a "
              "controller in a car, not at a desk",
              is_arm(machine) ? "linux-image-rt-arm64" : "linux-image-rt-amd64"));
  examine_rights(machine, needs, all);
  examine_cpus(machine, needs, all);
  for (const InterruptThread& thread : machine.interrupts)
    if (thread.priority <= needs.priority)
      all.push_back(
          found(kind("interrupt_below_beat"), thread.name,
                fmt::format("has priority {}, not above the beat's {}: frames wait for the tick",
                            thread.priority, needs.priority),
                fmt::format("{} {}", std::max(usual_interrupt_priority, needs.priority + 1),
                            thread.pid)));
  const bool asks_for_more = machine.has_service || !machine.may_exceed_buffer;
  if (asks_for_more && machine.largest_buffer < needs.receive_buffer)
    all.push_back(found(
        kind("small_receive_buffer"), "net.core.rmem_max",
        fmt::format("is {} bytes, odomd asks for {}", machine.largest_buffer, needs.receive_buffer),
        std::to_string(needs.receive_buffer)));
  constexpr const Kind& full = kind("disk_nearly_full");
  if (!full.limits.hold(machine.free_gb))
    all.push_back(found(full, machine.folder,
                        fmt::format("{:.2f} GB are free for recordings", machine.free_gb)));
  return all;
}

}  // namespace odomd::tools::doctor
