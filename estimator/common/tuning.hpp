// All numbers that were chosen, not measured: assumptions of the filter about cars, drivers and
// sensors. They are dimensionless, or scale with gravity, the wheelbase, the speed or a sensor's
// stated sigma, so that they hold for a car of any size.
//
// docs/model.md uses their names. Units are in brackets (none: a ratio).
#pragma once

namespace odomd::estimator {

inline constexpr double gravity = 9.81;  // [m/s²]

/// "GM" is a Gauss-Markov process of this standard deviation and correlation time.
///
/// Origins: physics, then simulated cars (NEES, NIS, drift) and the training drives, except for:
/// side_slip, spin, sliding_slip, slip_share, velocity_odds: simulated slides.
/// side_slip_grip, grip_used, grip_shown_s: v_y in the first half of revs_250lm, and for the last
/// two also in xray_duck_1. slip_noise, wheel_noise_scale_range: the wheels of revs_250lm, and
/// braking simulated cars. signal_gate: χ² of one degree of freedom. turn_noise_scale_range: the
/// gyro's NIS on simulated full-size cars, and v_y as above. outlier_share: assumed.
struct Tuning {
  // --- how the car is driven ---
  double drive_accel = 0.1;  ///< a_x, GM: braking and acceleration by the driver [g]
  double front_angle = 0.2;  ///< ε, GM: error of the front wheels' angle [rad]
  double driving_s = 0.5;    ///< correlation time of a_x and ε [s]

  // --- model errors ---
  double side_force = 0.1;         ///< e, GM: relative error of the tyre force
  double side_force_floor = 0.01;  ///< e: sigma in a straight line [g]
  double side_force_s = 0.05;      ///< e: correlation time [s]
  double side_slip = 0.06;         ///< white noise of v̇_y at 1 g, growing with a_y³ [g √s]
  double side_slip_grip = 0.4;     ///< factor on side_slip if the tyres' grip is known
  double side_slip_floor = 0.01;   ///< white noise of v̇_y in a straight line [g √s]
  double turn = 0.3;               ///< white noise of ψ̈, in sigmas of the gyro [1/√s]
  double way = 1e-3;               ///< white noise of the position, per √(distance · wheelbase)
  double way_turn = 1e-4;     ///< white noise of the heading, per √(distance / wheelbase) [rad]
  double slope = 0.015;       ///< random walk of the road's slope along the car [rad/√m]
  double bank = 0.007;        ///< random walk of the road's slope across the car [rad/√m]
  double accel_scale = 0.02;  ///< scale error of an accelerometer

  // --- wheels ---
  double wheel_radius = 0.0025;  ///< relative difference between the wheels' radii
  double slip_noise = 0.0025;    ///< variation of a driven wheel's slip, per acceleration [s²/m]
  double sliding_slip = 0.2;     ///< wheel slip of a sliding car, relative to its speed
  double spin = 0.25;            ///< sigma of a driven wheel's spin, relative to slide_of()
  double slip_memory_s = 20.0;   ///< decay time of a detected slip [s]
  double slip_share = 0.4;       ///< sigma of a wheel that has just slipped, relative to its slip
  double front_wheel = 0.05;     ///< error of δ at a front wheel [rad]

  // --- gates ---
  double signal_gate = 20.0;  ///< ν²/S of a scalar sample: 4.5 σ
  double wheel_gate = 100.0;  ///< ν²/S of a wheel, whose noise has heavy tails: 10 σ
  double pedal = 0.3;         ///< sudden change of a_x by brakes or motor, one sigma [g]
  double turn_in = 2.0;       ///< fastest change of ψ̇ that is not an outlier [g / wheelbase]

  // --- standing ---
  double standing_odds = 4.6;     ///< log odds at which the car stands: 100 : 1
  double most_odds = 22.0;        ///< most log odds that the wheels alone contribute
  double bias_step_odds = 16.0;   ///< log odds against a step of the gyro's bias
  double still_s = 0.06;          ///< mean time that a moving car's wheels read 0 [s]
  double still_per_speed = 0.35;  ///< increase of still_s per dead band [s²/m]
  double departs_s = 0.5;         ///< silence of the wheels that lowers the log odds by 1 [s]
  double reversing = 0.63;        ///< σ of a distance of unknown sign / distance: 2 √(1/10)
  double dead_band = 0.3;  ///< dead band of wheels, until they show a smaller one [wheelbases/s]
  double sharpest_turn = 0.55;  ///< tan δ of the tightest turn

  // --- camera poses beyond the gate ---
  double outlier_odds = 12.0;   ///< prior log odds that poses are outliers, not the filter wrong
  double velocity_odds = 4.6;   ///< prior log odds that the filter's velocity is right, not wrong
  double outlier_share = 0.01;  ///< share of outliers among the poses that a map begins with
  double outlier_range = 20.0;  ///< spread of outliers over the map [wheelbases]
  double motion_error = 0.1;    ///< error of the filter's motion between two poses [1, rad/m]
  double camera_latency = 0.0025;  ///< lasting error of a camera's stamps: half an exposure [s]
  double lasting_s = 3.0;          ///< correlation time of a camera's lasting error [s]
  double lasting_mean_s = 0.5;     ///< averaging time of m, the mean of a camera's innovations [s]
  double lasting_memory_s = 20.0;  ///< averaging time of the innovations' correlation with m [s]
  double fault_share = 0.5;  ///< sigma of a fault's effect on the pose, relative to that effect
  double disputed_s = 60.0;  ///< decay time of the variance that a correction may hide [s]

  // --- noise of gyro and accelerometers from the data (ratios to the stated variance) ---
  int noise_samples = 300;    ///< number of averaged samples
  double noise_range = 10.0;  ///< moving: from 1 / this to this; at rest: from 1 / this² to 1

  // --- noise scales from the data: time constants and ranges (ratios of variances) ---
  double turn_noise_scale_s = 2.0;  ///< time constant of the scale of ε, learnt from the gyro [s]
  double turn_noise_scale_range = 2500.0;  ///< scale of ε: from 1 / this to 1
  double wheel_noise_scale_s = 5.0;  ///< time constant of the scales of a_x and wheel errors [s]
  double drive_noise_scale_range = 10.0;  ///< scale of a_x: from 1 / this to this
  double wheel_noise_scale_range = 36.0;  ///< scale of wheel errors: from 1 / this to this
  double way_noise_scale_s = 0.5;         ///< time constant of the scale of position noise [s]
  double way_noise_scale_range = 1e4;     ///< scale of position noise: from 1 to this

  // --- slow errors and calibrations: prior standard deviations ---
  double gyro_bias = 0.03;          ///< b_g [rad/s]
  double gyro_scale = 0.02;         ///< s_g
  double wheel_scale = 0.03;        ///< s_w
  double wheel_slip = 0.02;         ///< c_s: slip of a driven wheel, per acceleration [s²/m]
  double stiffness_scale = 0.15;    ///< κ
  double roll_gradient = 0.1;       ///< ρ_y [rad/g]
  double pitch_gradient = 0.05;     ///< ρ_x [rad/g]
  double accel_bias = 0.3;          ///< b_ax, b_ay [m/s²]
  double steering_offset = 0.02;    ///< δ_0 [rad]
  double latency = 0.02;            ///< τ_g, τ_w, τ_δ [s]
  double wheel_difference = 0.005;  ///< d
  double tyre_softness = 0.04;      ///< 1/μ of tyres without a configured grip [s²/m]
  double softness = 0.05;           ///< 1/μ: sigma [s²/m]
  double grip_used = 0.8;           ///< largest share of its grip that a tyre uses
  double grip_shown_s = 0.3;        ///< averaging time of the a_y that grip_used limits [s]

  // --- random walks of slow errors and calibrations, per √s ---
  double gyro_bias_walk = 6e-5;         ///< b_g [rad/s/√s]
  double gyro_bias_walk_share = 0.012;  ///< b_g of a noisier gyro, per noise at rest [1/√s]
  double gyro_scale_walk = 2e-5;        ///< s_g [1/√s]
  double accel_bias_walk = 3e-3;        ///< b_ax, b_ay [m/s²/√s]
  double wheel_scale_walk = 1.5e-3;     ///< s_w [1/√s]
  double steering_offset_walk = 1e-4;   ///< δ_0 [rad/√s]
  double stiffness_scale_walk = 2e-3;   ///< κ [1/√s]
};

}  // namespace odomd::estimator
