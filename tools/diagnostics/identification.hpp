// Diagnostics of experiments: limits of the values that odom identify determines.
#pragma once

#include <array>

#include "daemon/diagnostics/kind.hpp"

namespace odomd::diagnostics {

// Code, name, meaning, fix; of some also limits, unit and reason.
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
     "the uncertainty is larger for it"},
    {"W522", "swing_not_free", "The swing is not a free pendulum's.",
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

}  // namespace odomd::diagnostics
