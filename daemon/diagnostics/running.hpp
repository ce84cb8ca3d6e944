// Diagnostics of a running daemon, from its status. Those of its sensors are in sensors.hpp.
#pragma once

#include <array>

#include "daemon/diagnostics/kind.hpp"

namespace odomd::diagnostics {

inline constexpr auto running = std::to_array<Kind>({
    {.code = "W801",
     .name = "other_version",
     .meaning = "odom and odomd have different versions.",
     .fix = "install both from one build, then restart odomd: sudo systemctl restart {SERVICE}"},
    {.code = "W802",
     .name = "beat_wakes_late",
     .meaning = "The machine wakes the beat too late: poses are missing.",
     .fix = "follow \"Real time\" in docs/operations.md; sudo cyclictest -m -p 80 -i 5000 shows "
            "the machine's lateness",
     .limits = {.most = 0.001},
     .reason = "share of cycles missed"},
    {.code = "W803",
     .name = "ticks_too_long",
     .meaning = "A tick takes longer than its period: poses are missing.",
     .fix = "write a longer period under [realtime], or a cheaper [filter] model",
     .limits = {.most = 1.0},
     .unit = "periods",
     .reason = "execution time of all but one in a thousand ticks"},
    {.code = "W804",
     .name = "frames_lost",
     .meaning = "Frames were lost between bus and odomd.",
     .fix = "write receive_buffer = 4194304 under [can], and run sudo sysctl "
            "net.core.rmem_max=4194304",
     .limits = {.most = 1e-4},
     .reason = "share of frames"},
    {.code = "W805",
     .name = "signal_overdue",
     .meaning = "A signal has stopped arriving.",
     .fix = "check its sender; candump {INTERFACE} shows what comes"},
    {.code = "W806",
     .name = "camera_silent",
     .meaning = "[camera] is configured, but no pose comes.",
     .fix = "start the camera, or try odom camera send --pose 0,0,0; without a camera remove "
            "[camera]"},
    {.code = "W807",
     .name = "camera_messages_malformed",
     .meaning = "Messages of the camera are not poses.",
     .fix = "send odom_camera_message of odom/odom.h, as docs/camera.md describes it"},
    {.code = "W808",
     .name = "sigma_off",
     .meaning = "A source's scatter contradicts its sigma.",
     .fix = "multiply {KEY by FACTOR}",
     .limits = {0.05, 4.0},
     .reason = "mean NIS over its dimension, 1 if the sigma is right"},
    {.code = "W809",
     .name = "camera_times",
     .meaning = "Camera poses are too old or from the future.",
     .fix = "send the capture time in CLOCK_MONOTONIC, in nanoseconds; or raise max_latency under "
            "[camera]",
     .limits = {.most = 0.25},
     .reason = "share of its poses"},
    {.code = "W810",
     .name = "cpu_not_pinned",
     .meaning = "The beat runs on another CPU than [realtime] cpu.",
     .fix = "write a CPU that exists and that the service may use"},
    {.code = "W811",
     .name = "controller_overflows",
     .meaning = "The CAN controller lost frames.",
     .fix = "raise its interrupt thread above the beat (docs/operations.md, Real time), or use a "
            "controller with a larger buffer",
     .limits = {.most = 1e-4},
     .reason = "share of frames"},
    {.code = "W812",
     .name = "camera_refused",
     .meaning = "A process was refused as a camera.",
     .fix = "stop one of the senders, or add its user to the group of the socket; odomd's log says "
            "which"},
});

}  // namespace odomd::diagnostics
