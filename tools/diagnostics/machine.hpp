// Diagnostics of the machine that odomd runs on: causes of late ticks, and missing permissions.
#pragma once

#include <array>

#include "daemon/diagnostics/kind.hpp"

namespace odomd::diagnostics {

// Code, name, meaning, fix; of some also limits, unit and reason.
inline constexpr auto machine = std::to_array<Kind>({
    {"W601", "no_realtime_kernel", "The kernel is not PREEMPT_RT: poses may come late.",
     "on a car: sudo apt install {PACKAGE} && sudo reboot"},
    {"W602", "no_realtime_priority", "odomd may not use SCHED_FIFO with its priority.",
     "started by hand: write the line \"{USER - rtprio PRIORITY}\" into "
     "/etc/security/limits.d/odomd.conf and log in again; as a service: the same number as "
     "LimitRTPRIO= under [Service] in sudo systemctl edit odomd@.service"},
    {"W603", "memory_not_locked", "odomd may not lock its memory: a tick may wait for a page.",
     "started by hand: write the line \"{USER} - memlock unlimited\" into "
     "/etc/security/limits.d/odomd.conf and log in again; as a service: LimitMEMLOCK=infinity "
     "under [Service] in sudo systemctl edit odomd@.service"},
    {"W604",
     "cpus_sleep_deeply",
     "CPUs may enter deep sleep, and wake late.",
     "sudo chgrp {GROUP} /dev/cpu_dma_latency && sudo chmod g+rw /dev/cpu_dma_latency; for the "
     "service the package's udev rule does so at every boot",
     {.most = 50.0},
     "µs",
     "time to wake from the deepest sleep"},
    {"W605",
     "realtime_throttled",
     "The kernel throttles real-time threads.",
     "sudo sysctl kernel.sched_rt_runtime_us=950000",
     {.least = 0.5},
     "",
     "share of the time that they may run; Linux has 0.95"},
    {"W606", "slow_clock", "The kernel's clock is slow to read.",
     "echo {CLOCK} | sudo tee /sys/devices/system/clocksource/clocksource0/current_clocksource; if "
     "refused, see journalctl -k -g clocksource"},
    {"W607", "cpu_frequency_changes", "The CPUs lower their clock frequency.",
     "sudo apt install linux-cpupower && sudo cpupower frequency-set -g performance"},
    {"W609", "small_receive_buffer", "The receive buffer is limited; a busy bus may lose frames.",
     "echo net.core.rmem_max={BYTES} | sudo tee /etc/sysctl.d/60-odomd.conf && sudo sysctl "
     "--system"},
    {"W610", "service_account_missing", "The service's user and groups are missing.",
     "sudo systemd-sysusers"},
    {"W611", "not_in_group", "You may not read the service's pose and status.",
     "sudo usermod -aG odom {USER}, and log in again"},
    {"W612", "login_before_group", "This login is older than your membership in odom.",
     "log out and in again; for this terminal: newgrp odom"},
    {"W613",
     "disk_nearly_full",
     "There is little space for recordings.",
     "df -h shows other disks; odom record --out FOLDER records there",
     {.least = 1.0},
     "GB",
     "an hour of a busy bus"},
});

}  // namespace odomd::diagnostics
