// The kinds of diagnostics that only the tools give, and the table of all kinds, from which
// docs/diagnostics.md is generated. Columns: code, name, meaning, fix; some rows also have limits,
// their unit and their reason.
#pragma once

#include "daemon/diagnostics/diagnostic.hpp"

namespace odomd::diagnostics {

/// Poses of the camera, of the reference and of an estimate.
inline constexpr auto poses = std::to_array<Kind>({
    {"W401", "positions_in_millimetres", "Positions are 1000 times too large.",
     "positions must be in metres"},
    {"W402", "positions_in_centimetres", "Positions are 100 times too large.",
     "positions must be in metres"},
    {"W403", "yaw_in_degrees", "Headings are 57 times too large.", "yaw must be in radians"},
    {"W404", "headings_off_path", "The headings do not follow the path.",
     "yaw must be in radians, counter-clockwise from the x axis", at_least(0.65), "",
     "agreement of course and heading; a long drift has 0.77"},
    {"W405", "no_camera_pose", "The camera's file has no pose.",
     "check whether the tracker saw the car"},
    {"W406", "camera_columns_exchanged", "Camera poses arrive before their capture.",
     "check whether the columns t_arrival and t_capture are exchanged"},
    {"W407", "camera_outside_log", "No camera pose falls into the log.",
     "name the camera's file of this drive, and put its times on the log's clock"},
    {"W408", "initial_pose_elsewhere", "The initial pose is far from the camera's first.",
     "remove [initial] pose to start from the first camera pose, or set this drive's", at_most(0.5),
     "m or rad", "excess over 5 sigmas + possible motion"},
    {"W409", "clocks_differ", "Poses are not on the log's clock.",
     "put them on the log's clock, t_capture at the time of the picture, or state the "
     "signals' latencies (odom identify latency)"},
    {"W410", "other_drive", "Reference and estimate turn differently.",
     "check that both are of one drive and clock, and the yaw's sign", at_most(0.7), "",
     "rms of the difference over rms of the turn"},
    {"W411", "exchanged", "The reference has sigmas, the estimate none.",
     "check whether --reference and --pose are exchanged"},
    {"W412", "reference_covers_part", "The reference covers part of the estimate.",
     "the rest is not evaluated", at_least(0.9), "", "share of the time"},
    {"W413", "estimate_covers_part", "The estimate covers part of the reference.",
     "all figures are for that part only", at_least(0.9), "", "share of the path"},
    {"W414", "reference_gap", "The reference has a gap.",
     "it is bridged by a straight line; --from and --to leave a part out", at_most(0.2), "s",
     "no path is straight for longer"},
    {"W415", "reference_jumps", "The reference jumps.",
     "path length, maxima and 35 ms errors include these jumps", at_most(100.0), "m/s",
     "faster than any car"},
    {"W416", "reference_stuck", "The reference stops while the estimate moves.",
     "check whether its tracker lost the car or the wheels spin; --from and --to leave a "
     "part out"},
    {"W417", "other_time", "The estimates cover different times.",
     "compare their figures with care", at_most(0.01), "", "share of the time"},
    {"W418", "loop_closes_badly", "The drive does not end where it began.",
     "the figures include the car's distance from its start"},
    {"W419", "camera_turns_unrelated", "The poses' turns and the gyro's are unrelated.",
     "check the file's drive and clock, and that yaw_rate is the right signal"},
});

/// Experiments: limits of the values that odom identify determines.
inline constexpr auto identification = std::to_array<Kind>({
    {"W501", "another_value", "A new value is far from the old one.",
     "is it another car, or another unit?"},
    {"W502", "more_precise_kept", "The more precise configured value is kept.",
     "--force replaces it"},
    {"W511", "weighings_contradict", "The car's weighings contradict each other.",
     "did the car stand level, touch nothing, and have the same load each time?"},
    {"W512", "scale_coarse", "The mass is uncertain.",
     "is the unit of --scale-resolution, --scale-sigma, --scale-accuracy or --level correct?",
     at_most(0.02), "", "two sigma, relative"},
    {"W513", "another_wheelbase", "The measured wheelbase differs from the configured one.",
     "measure again between the centres of the wheels, both sides"},
    {"W515", "centre_off_side",
     "The centre of gravity is far to one side; the models assume the middle.", "move the battery"},
    {"W521", "timings_scatter", "The swing's timings scatter more than stated.",
     "the uncertainty allows for this"},
    {"W522", "swing_not_free", "The pendulum does not swing freely.",
     "the car sways, or something brakes it; let it go without a push"},
    {"W523", "measured_inertia_unlike", "The measured yaw inertia contradicts mass and axles.",
     "were passages counted instead of full swings, or is a length in another unit?"},
    {"W524", "inertia_uncertain", "The yaw inertia is uncertain.",
     "measure the largest contribution more precisely", at_most(0.02), "", "two sigma, relative"},
    {"W531", "disturbed_record", "A record at rest has outliers.",
     "was the car touched? Log it undisturbed, or cut with --from, --to"},
    {"W533", "standstill_unconfirmed", "No wheel speed confirms the standstill.",
     "the IMU would not see a slow straight roll"},
    {"W541", "latencies_relative", "All latencies are relative to the gyro's.",
     "with --camera it is measured"},
    {"W551", "film_scale_off", "The film's scale contradicts the markers' measured distance.",
     "measure both again, or leave the scale out"},
    {"W552", "film_rows_left_out", "Rows of a film are not used.", ""},
    {"W553", "film_clock_off", "The film's clock differs from the log's.",
     "were frames dropped, or is it another frame rate (odom identify track --fps)?"},
    {"W554", "film_start_ambiguous", "The start of the film is ambiguous.",
     "if it does, also film the start from standing"},
    {"W555", "no_circle", "A film has no steady circle.",
     "hold steering and speed for half a turn or more"},
    {"W556", "circle_left_out", "The log lacks a circle's samples.",
     "log the signals at 10 per second or more, without gaps"},
    {"W557", "film_acceleration_off", "Accelerometer and film disagree.",
     "check the film's scale and frame rate, and the unit of [can.signals] accel_y"},
    {"W558", "circles_one_sided", "All circles turn to one side: offsets look like slip.",
     "drive circles to the {SIDE} too"},
    {"W559", "no_rear_marker", "No marker is behind the centre of gravity.",
     "--front and --rear are measured from it, negative behind it"},
    {"W560", "circles_as_fast",
     "All circles have one speed: the steering's scale and the markers' places look like slip.",
     "drive slow ones too, with a quarter of the lateral acceleration"},
    {"W561", "stiffness_uncertain", "A stiffness is uncertain.",
     "drive faster circles, and slow ones too", at_most(0.05), "", "two sigma, relative"},
    {"W562", "centre_contradicted", "The circles give a different centre of gravity.",
     "measure --front and --rear from the centre of gravity, negative behind it, and check "
     "front_axle and rear_axle"},
    {"W563", "steering_contradicted", "Steering angles of circles and log differ.",
     "correct the scale of [can.signals] steering, or the places of the markers"},
    {"W564", "circles_off_curve", "Most circles are off the tyre curve.",
     "check the places of the markers, their track, and front_axle and rear_axle"},
    {"W571", "one_speed", "All turns have one speed: parameters look alike.",
     "drive turns at three speeds (odom sim --scenario exercise), or --fix known parameters"},
    {"W572", "hard_turns", "Much of the drive exceeds half of the grip.", "drive more gently",
     at_most(0.03), "", "share of the drive"},
    {"W573", "poses_stamped_late", "A negative latency: the poses' stamps look late.",
     "stamp poses with the time the picture was taken"},
    {"W574", "not_converged", "The fit did not converge.",
     "poses and log may not belong together, or the drive has too little excitation; "
     "--fix parameters"},
});

/// The machine that odomd runs on: causes of late ticks, and missing permissions.
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
     "A listen-only interface receives nothing, or one frame repeatedly.",
     "if the bus has only one other node, set it down, then sudo ip link set {INTERFACE} "
     "type can listen-only off, and up again"},
    {"W711", "no_frames", "No frame arrives.",
     "check that the car is on, the wiring, and the bit rate"},
    {"W712", "other_database", "Frames come, but none of the mapped messages.",
     "check that can.dbc names this car's database, and can.source the right bus"},
    {"W713", "other_id_format", "A mapped message's identifier comes in the other format.",
     "give its BO_ in the database the number {NUMBER}"},
    {"W714", "other_rate", "A mapped message's rate differs from the database.",
     "if its sender is right, write {LINE} in the database", within(0.5, 1.5), "",
     "ratio to GenMsgCycleTime"},
});

/// Faults of a running daemon, from its status. Those of its sensors are in `sensors`.
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

namespace odomd::tools {

/// In the order of the codes.
inline constexpr std::array all_chapters{
    diagnostics::chapters[0],
    diagnostics::chapters[1],
    diagnostics::chapters[2],
    diagnostics::Chapter{"Poses: camera, reference and estimate", diagnostics::poses},
    diagnostics::Chapter{"Identification", diagnostics::identification},
    diagnostics::Chapter{"The machine", diagnostics::machine},
    diagnostics::Chapter{"CAN buses", diagnostics::bus},
    diagnostics::Chapter{"The running daemon", diagnostics::running},
};

[[nodiscard]] consteval const diagnostics::Kind& kind(std::string_view name) {
  return diagnostics::kind(name, all_chapters);
}

}  // namespace odomd::tools
