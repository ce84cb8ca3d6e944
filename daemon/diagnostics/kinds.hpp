// The kinds of diagnostics that the daemon and odomd --check give, by subject, in the order of
// their codes: code, name, meaning, fix, and for values the limits, their unit and reason.
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

}  // namespace odomd::diagnostics
