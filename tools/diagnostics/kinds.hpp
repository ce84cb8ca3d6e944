// All kinds of diagnostics: those of the daemon, and of experiments and machines, which only tools
// examine. docs/diagnostics.md is generated from them.
#pragma once

#include <array>

#include "daemon/diagnostics/diagnostic.hpp"

namespace odomd::diagnostics {

// Code, name, meaning, fix; of some also limits, unit and reason.

/// Limits of the values that odom identify determines.
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

/// Causes of late ticks, and missing permissions.
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

}  // namespace odomd::diagnostics

namespace odomd::tools {

/// In the order of the codes.
inline constexpr std::array all_chapters{
    diagnostics::chapters[0],
    diagnostics::chapters[1],
    diagnostics::chapters[2],
    diagnostics::chapters[3],
    diagnostics::Chapter{"Identification", diagnostics::identification},
    diagnostics::Chapter{"The machine", diagnostics::machine},
    diagnostics::chapters[4],
    diagnostics::chapters[5],
};

[[nodiscard]] consteval const diagnostics::Kind& kind(std::string_view name) {
  return diagnostics::kind(name, all_chapters);
}

}  // namespace odomd::tools
