// Diagnostics of a running odomd: of its machine (causes of late ticks, missing permissions), of
// its buses, and of itself.
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
    {"W604", "cpus_sleep_deeply", "CPUs may enter deep sleep, and wake late.",
     "sudo chgrp {GROUP} /dev/cpu_dma_latency && sudo chmod g+rw /dev/cpu_dma_latency; for the "
     "service the package's udev rule does so at every boot",
     at_most(50.0), "µs", "time to wake from the deepest sleep"},
    {"W605", "realtime_throttled", "The kernel throttles real-time threads.",
     "sudo sysctl kernel.sched_rt_runtime_us=950000", at_least(0.5), "",
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
    {"W613", "disk_nearly_full", "There is little space for recordings.",
     "df -h shows other disks; odom record --out FOLDER records there", at_least(1.0), "GB",
     "an hour of a busy bus"},
});

/// CAN buses: their interfaces and their traffic.
inline constexpr auto bus = std::to_array<Kind>({
    {"W701", "interface_missing", "A CAN interface does not exist.",
     "connect it and load its driver; ip -brief link show lists what there is"},
    {"W702", "interface_not_can", "An interface is not CAN.",
     "name another; ip -brief link show type can lists them"},
    {"W703", "interface_down", "A CAN interface is down.", "sudo ip link set {INTERFACE} up"},
    {"W704", "no_bit_rate", "A CAN controller has no bit rate.",
     "sudo ip link set {INTERFACE} type can bitrate 500000 restart-ms 100, with the bus's "
     "bit rate, and set it up"},
    {"W705", "no_restart", "A CAN controller does not restart after bus-off.",
     "set it down, then sudo ip link set {INTERFACE} type can restart-ms 100, and up again"},
    {"W706", "bus_errors", "A CAN controller sees many errors.",
     "check the bit rate of {INTERFACE}, the bus's two terminating resistors and the wiring"},
    {"W707", "bus_off", "A CAN controller has left the bus.",
     "check bit rate and wiring, then set {INTERFACE} down and up again"},
    {"W708", "no_can_fd", "A mapped message is CAN FD, but the interface is not.",
     "set it down, then sudo ip link set {INTERFACE} type can bitrate 500000 dbitrate 2000000 "
     "fd on, with the rates of the bus (a virtual one: mtu 72), and up again"},
    {"W709", "nobody_acknowledges",
     "A listen-only interface hears nothing, or one frame repeatedly.",
     "if the bus has only one other node, set it down, then sudo ip link set {INTERFACE} "
     "type can listen-only off, and up again"},
    {"W711", "no_frames", "No frame comes.",
     "check that the car is on, the wiring, and the bit rate"},
    {"W712", "other_database", "Frames come, but none of the mapped messages.",
     "check that can.dbc names this car's database, and can.source the right bus"},
    {"W713", "other_id_format", "A mapped message's identifier comes in the other format.",
     "give its BO_ in the database the number {NUMBER}"},
    {"W714", "other_rate", "A mapped message's rate differs from the database.",
     "if its sender is right, write {LINE} in the database", within(0.5, 1.5), "",
     "ratio to GenMsgCycleTime"},
});

/// A running daemon, from its status. Those of its sensors are in `sensors`.
inline constexpr auto running = std::to_array<Kind>({
    {"W801", "other_version", "odom and odomd have different versions.",
     "install both from one build, then restart odomd: sudo systemctl restart {SERVICE}"},
    {"W802", "beat_wakes_late", "The machine wakes the beat too late: poses are missing.",
     "follow \"Real time\" in docs/operations.md; sudo cyclictest -m -p 80 -i 5000 shows "
     "the machine's lateness",
     at_most(0.001), "", "share of cycles missed"},
    {"W803", "ticks_too_long", "A tick takes longer than its period: poses are missing.",
     "write a longer period under [realtime], or a cheaper [filter] model", at_most(1.0), "periods",
     "execution time of all but one in a thousand ticks"},
    {"W804", "frames_lost", "Frames were lost between bus and odomd.",
     "write receive_buffer = 4194304 under [can], and run sudo sysctl "
     "net.core.rmem_max=4194304",
     at_most(1e-4), "", "share of frames"},
    {"W805", "signal_overdue", "A signal has stopped arriving.",
     "check its sender; candump {INTERFACE} shows what comes"},
    {"W806", "camera_silent", "[camera] is configured, but no pose comes.",
     "start the camera, or try odom camera send --pose 0,0,0; without a camera remove "
     "[camera]"},
    {"W807", "camera_messages_malformed", "Messages of the camera are not poses.",
     "send odom_camera_message of odom/odom.h, as docs/camera.md describes it"},
    {"W808", "sigma_off", "A source's scatter contradicts its sigma.", "multiply {KEY by FACTOR}",
     within(0.05, 4.0), "", "mean NIS over its dimension, 1 if the sigma is right"},
    {"W809", "camera_times", "Camera poses are too old or from the future.",
     "send the capture time in CLOCK_MONOTONIC, in nanoseconds; or raise max_latency under "
     "[camera]",
     at_most(0.25), "", "share of its poses"},
    {"W810", "cpu_not_pinned", "The beat runs on another CPU than [realtime] cpu.",
     "write a CPU that exists and that the service may use"},
    {"W811", "controller_overflows", "The CAN controller lost frames.",
     "raise its interrupt thread above the beat (docs/operations.md, Real time), or use a "
     "controller with a larger buffer",
     at_most(1e-4), "", "share of frames"},
    {"W812", "camera_refused", "A process was refused as a camera.",
     "stop one of the senders, or add its user to the group of the socket; odomd's log says "
     "which"},
});

}  // namespace odomd::diagnostics
