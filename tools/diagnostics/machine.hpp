// Diagnostics of the machine that odomd runs on: causes of late ticks, and missing permissions.
#pragma once

#include <array>

#include "daemon/diagnostics/kind.hpp"

namespace odomd::diagnostics {

inline constexpr auto machine = std::to_array<Kind>({
    {.code = "W601",
     .name = "no_realtime_kernel",
     .meaning = "The kernel is not PREEMPT_RT: poses may come late.",
     .fix = "on a car: sudo apt install {PACKAGE} && sudo reboot"},
    {.code = "W602",
     .name = "no_realtime_priority",
     .meaning = "odomd may not use SCHED_FIFO with its priority.",
     .fix = "started by hand: write the line \"{USER - rtprio PRIORITY}\" into "
            "/etc/security/limits.d/odomd.conf and log in again; as a service: the "
            "same number as LimitRTPRIO= under [Service] in sudo systemctl edit odomd@.service"},
    {.code = "W603",
     .name = "memory_not_locked",
     .meaning = "odomd may not lock its memory: a tick may wait for a page.",
     .fix = "started by hand: write the line \"{USER} - memlock unlimited\" into "
            "/etc/security/limits.d/odomd.conf and log in again; as a service: "
            "LimitMEMLOCK=infinity under [Service] in sudo systemctl edit odomd@.service"},
    {.code = "W604",
     .name = "cpus_sleep_deeply",
     .meaning = "CPUs may enter deep sleep, and wake late.",
     .fix =
         "sudo chgrp {GROUP} /dev/cpu_dma_latency && sudo chmod g+rw /dev/cpu_dma_latency; for the "
         "service the package's udev rule does so at every boot",
     .limits = {.most = 50.0},
     .unit = "µs",
     .reason = "time to wake from the deepest sleep"},
    {.code = "W605",
     .name = "realtime_throttled",
     .meaning = "The kernel throttles real-time threads.",
     .fix = "sudo sysctl kernel.sched_rt_runtime_us=950000",
     .limits = {.least = 0.5},
     .reason = "share of the time that they may run; Linux has 0.95"},
    {.code = "W606",
     .name = "slow_clock",
     .meaning = "The kernel's clock is slow to read.",
     .fix = "echo {CLOCK} | sudo tee "
            "/sys/devices/system/clocksource/clocksource0/current_clocksource; if refused, see "
            "journalctl -k -g clocksource"},
    {.code = "W607",
     .name = "cpu_frequency_changes",
     .meaning = "The CPUs lower their clock frequency.",
     .fix = "sudo apt install linux-cpupower && sudo cpupower frequency-set -g performance"},
    {.code = "W608",
     .name = "interrupt_below_beat",
     .meaning = "The CAN controller's interrupt thread has a lower priority than the beat: frames "
                "come a tick late.",
     .fix = "sudo chrt -f -p {PRIORITY PID}"},
    {.code = "W609",
     .name = "small_receive_buffer",
     .meaning = "The receive buffer is limited; a busy bus may lose frames.",
     .fix = "echo net.core.rmem_max={BYTES} | sudo tee /etc/sysctl.d/60-odomd.conf && sudo sysctl "
            "--system"},
    {.code = "W610",
     .name = "service_account_missing",
     .meaning = "The service's user and groups are missing.",
     .fix = "sudo systemd-sysusers"},
    {.code = "W611",
     .name = "not_in_group",
     .meaning = "You may not read the service's pose and status.",
     .fix = "sudo usermod -aG odom {USER}, and log in again"},
    {.code = "W612",
     .name = "login_before_group",
     .meaning = "This login is older than your membership in odom.",
     .fix = "log out and in again; for this terminal: newgrp odom"},
    {.code = "W613",
     .name = "disk_nearly_full",
     .meaning = "There is little space for recordings.",
     .fix = "df -h shows other disks; odom record --out FOLDER records there",
     .limits = {.least = 1.0},
     .unit = "GB",
     .reason = "an hour of a busy bus"},
});

}  // namespace odomd::diagnostics
