// The kinds of diagnostics that the daemon, odomd --check and replays give, by subject, in the
// order of their codes: code, name, meaning, fix, and for values the limits, their unit and reason.
#pragma once

#include <array>

#include "daemon/diagnostics/kind.hpp"

namespace odomd::diagnostics {

/// The configuration and its databases.
inline constexpr auto configuration = std::to_array<Kind>({
    {"W101", "reference_car", "No [vehicle]: the reference car is assumed.",
     "describe your car there"},
    {"W102", "mass_unlike_a_car", "Mass and wheelbase contradict each other.",
     "give mass in kilograms, front_axle and rear_axle in metres", within(5.0, 3000.0), "kg/m³",
     "mass over wheelbase cubed; a lorry has 80, a 1:10 car 170 to 300"},
    {"W103", "inertia_unlike_a_car", "The yaw inertia contradicts mass and axles.",
     "give it in kg·m²", within(0.15, 6.0), "",
     "yaw_inertia over mass·front_axle·rear_axle; cars have 0.4 to 1.2"},
    {"W104", "track_unlike_a_car", "The track width contradicts the wheelbase.",
     "give it in metres", within(0.2, 2.0), "", "track over wheelbase; cars have 0.5 to 0.8"},
    {"W105", "stiffness_unlike_a_tyre", "A cornering stiffness contradicts the car's weight.",
     "give it in N/rad for the whole axle", within(0.05, 80.0), "1/rad",
     "stiffness over weight; tyres have 0.5 to 10"},
    {"W106", "grip_unlike_a_tyre", "A grip is impossible for a tyre.",
     "give it in m/s², as lateral force divided by the mass on the axle", within(0.3, 50.0), "m/s²",
     "ice has 1, a road 5 to 15, racing 40"},
    {"W107", "sensor_outside_car", "Camera or IMU is outside the car.", "give it in metres",
     at_most(3.0), "wheelbases", "from the centre of gravity"},
    {"W108", "role_not_mapped", "The model uses a signal that is not mapped.",
     "map it in [can.signals] if the car has it"},
    {"W109", "actuator_without_steering", "[steering] without a steering signal.",
     "map steering, or leave [steering] out"},
    {"W110", "window_overflows", "[filter] window holds too many samples, and is shortened.",
     "map fewer signals, or lower window to {NUMBER}"},
    {"W111", "no_camera_file", "The configuration has a camera, the replay no poses.",
     "give --camera with its poses"},
    {"W112", "database_content", "A part of a database is unusual or left out.", ""},
});

/// Logs, recordings and their other files: what is missing or damaged.
inline constexpr auto records = std::to_array<Kind>({
    {"W201", "log_content", "A log is cut off or has unused lines.", ""},
    {"W202", "file_content", "A CSV file is cut off, or has unused rows.", ""},
    {"W203", "message_missing", "A mapped message never comes.",
     "check that it is on the bus, and database and id"},
    {"W204", "message_without_value", "A mapped message's frames give no value.",
     "check [can.e2e], valid_when, and the length in the database"},
    {"W205", "frames_cut_off", "Some frames of a message end before its signals.",
     "check whether the log is cut off within a line"},
    {"W206", "frames_late", "Frames are stamped far earlier than their predecessors.",
     "sort the log, or cut it where its clock was set back", at_most(1.0), "s",
     "adapters change the order by milliseconds"},
    {"W207", "replay_without_state", "A recording is replayed without the filter's state.",
     "record it again to compare bits"},
    {"W208", "no_pose", "The drive gives no pose.",
     "give an initial pose (--initial, [initial] pose, or a camera pose on the log's clock) "
     "and map a wheel speed"},
    {"W209", "model_fault", "The model left its valid range; do not rely on its poses.",
     "check the signals' scales and signs, the vehicle, and the databases"},
});

/// Sensors: how they are wired and described, and what they measure in a drive.
inline constexpr auto sensors = std::to_array<Kind>({
    {"W301", "wrong_sign", "A sensor shows the opposite of the others.",
     "check the sign of {KEY}.scale"},
    {"W302", "left_right_swapped", "Left and right wheels are exchanged.",
     "check the signal of {KEY}"},
    {"W303", "front_rear_swapped", "Front and rear wheels are exchanged.",
     "check the signal of {KEY}"},
    {"W304", "axes_swapped", "The accelerometer's axes are exchanged.",
     "check the signal of {KEY}, or imu.yaw"},
    {"W305", "wrong_unit", "A sensor's unit or scale is wrong.", "check unit and scale of {KEY}"},
    {"W306", "camera_mirrored", "The camera turns opposite to the sensors.",
     "its yaw must be counter-clockwise, and its map not mirrored"},
    {"W307", "camera_wrong_unit", "The camera's positions are in another unit.",
     "its positions must be in metres"},
    {"W308", "runs_backwards", "A wheel turns backwards while the camera sees forward motion.",
     "check the sign of {KEY}.scale, or camera.lever_arm[2]"},
    {"W309", "scale_off", "A sensor measures too much or too little.",
     "check unit, scale and radius of {KEY}, or drive without spinning wheels",
     within(1.0 / 1.5, 1.5), "", "ratio to poses; 1/3 to 3 without"},
    {"W311", "out_of_range", "A value is impossible for a car.", "check its scale and wiring"},
    {"W312", "not_a_number", "A value is NaN or infinite.", "check its signal in the database"},
    {"W313", "frozen", "A sensor repeats one value while the car moves.",
     "check its wiring, its power and its measuring range"},
    {"W314", "contradicts_others", "A sensor contradicts the other sensors.",
     "check its scale, offset and mounting"},
    {"W315", "protection_failed", "A message fails its end-to-end protection.",
     "see odom status for its counters, and check [can.e2e]"},
    {"W316", "inconsistent", "A source has not fitted the filter's prediction for seconds.",
     "check its sigma, latency and scale, and [vehicle]"},
    {"W317", "often_gated",
     "Many samples of a source differ too much from the filter's prediction.", "check {KEY}",
     at_most(0.1), "", "share of its samples"},
    {"W318", "actuator_not_seen", "Steering delay and lag differ from [steering].",
     "if the angle is measured, leave [steering] out"},
    {"W319", "latency_off", "A measured latency differs from the configured one.",
     "write {KEY = SECONDS}; odom identify latency measures it", at_most(0.02), "s",
     "against other sensors and the camera"},
    {"W320", "bias_unlearnt", "The gyro's bias is unknown: the heading drifts.",
     "let the car stand for 2 s"},
    {"W321", "scale_implausible", "A learnt scale is far from its configured value.",
     "check scale and radius under [can.signals], and [vehicle]"},
    {"W322", "source_unused", "A source is unused, or used in part.", "{KEY}", at_most(0.1), "",
     "share of samples or time"},
});

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
