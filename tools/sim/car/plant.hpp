// The simulated car: four wheels on a plane. Deliberately different from the models of all filters:
// the tyres saturate and need a distance to build up force, load moves between the wheels, the
// driven wheels slip, the steering lags, and the car comes to rest exactly. With a suspension its
// body rolls and pitches (chassis.hpp). Also the cars that can be simulated (cars.cpp).
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <deque>
#include <string>
#include <string_view>
#include <vector>

#include "estimator/common/vehicle.hpp"
#include "tools/sim/car/chassis.hpp"
#include "tools/sim/car/parameters.hpp"

namespace odomd::sim {

/// The force of one tyre: saturating, load-dependent, with combined longitudinal and lateral slip.
///
/// Each slip is normalised to (force of a linear tyre at this slip) / (largest force by friction):
///
///   s_x = C_κ κ / (μ F_z),   s_y = C_α tan α / (μ F_z),   s = √(s_x² + s_y²)
///
/// and the resultant follows Pacejka's sine with unit initial slope (B = 1/c, D = 1, E = 0):
///
///   F = μ F_z sin(c atan(s / c)),   along (s_x, s_y)
///
/// so that the slopes at zero slip are exactly C_κ and C_α, the force never exceeds the friction
/// circle μ F_z, and falls beyond the peak. Both stiffnesses grow less than proportionally to the
/// load: C(F_z) = C(F_z0) (F_z / F_z0)^p, p < 1, so that load transfer costs grip. (H. Pacejka,
/// Tire and Vehicle Dynamics, chapters 3 and 4.)
struct Tyre {
  double cornering_stiffness = 0.0;  ///< C_α at the nominal load [N/rad]
  double slip_stiffness = 0.0;       ///< C_κ at the nominal load [N]
  double nominal_load = 0.0;         ///< F_z0 [N]
  double shape = 1.35;               ///< c; 1 saturates without a peak, up to 2
  double load_exponent = 0.8;        ///< p
};

/// The force along the wheel and to its left [N]. `slip_x` is κ (positive if the wheel drives),
/// `slip_y` is tan α (positive if the force points to the left). A wheel without load gives no
/// force.
[[nodiscard]] Vector2 tyre_force(const Tyre& tyre, double load, double friction, double slip_x,
                                 double slip_y);

enum Wheel : std::size_t { front_left, front_right, rear_left, rear_right, wheel_count };

/// The observable motion of the car's centre of gravity at one time. All members are doubles, so
/// that two outputs can be interpolated.
struct PlantOutput {
  double x = 0.0, y = 0.0, yaw = 0.0;  ///< yaw is continuous
  double v_x = 0.0, v_y = 0.0, yaw_rate = 0.0;
  /// Acceleration along the road without gravity, and d(yaw_rate)/dt.
  double accel_x = 0.0, accel_y = 0.0, yaw_accel = 0.0;
  double steering = 0.0;  ///< angle of the front wheels
  double commanded_steering = 0.0;
  std::array<double, wheel_count> wheel_angle{};  ///< turned since the start [rad]
  std::array<double, wheel_count> wheel_rate{};   ///< [rad/s]
  /// Attitude of the body relative to the road, and tilt of the road.
  double roll = 0.0, pitch = 0.0;
  double roll_rate = 0.0, pitch_rate = 0.0;
  double roll_accel = 0.0, pitch_accel = 0.0;
  double grade = 0.0, bank = 0.0;
  double grade_rate = 0.0, bank_rate = 0.0;

  [[nodiscard]] bool is_level() const {
    return roll == 0.0 && pitch == 0.0 && roll_rate == 0.0 && pitch_rate == 0.0 &&
           roll_accel == 0.0 && pitch_accel == 0.0 && grade == 0.0 && bank == 0.0;
  }
};

[[nodiscard]] PlantOutput interpolate(const PlantOutput& from, const PlantOutput& to, double part);

/// Specific force (as measured by an accelerometer) at a point of the body, in body axes; `z` is
/// the height above the ground.
[[nodiscard]] Vector2 specific_force_at(const PlantOutput& output, double x, double y,
                                        double z = 0.0);

/// The rate that a gyro measures about the body's own upward axis [rad/s].
[[nodiscard]] double body_yaw_rate(const PlantOutput& output);

/// A circular patch of road with a different friction coefficient.
struct FrictionPatch {
  double x = 0.0, y = 0.0, radius = 0.0;  ///< [m]
  double friction = 1.0;
};

/// SI units. Angles are those of the road wheels, not of the steering wheel.
struct PlantParameters {
  double mass = 0.0;
  double front_axle = 0.0;  ///< centre of gravity to front axle
  double rear_axle = 0.0;   ///< centre of gravity to rear axle
  double yaw_inertia = 0.0;
  double track_width = 0.0;                ///< mean of both axles
  double track_difference = 0.0;           ///< front track - rear track
  double centre_height = 0.0;              ///< of the centre of gravity, above the ground
  double cornering_stiffness_front = 0.0;  ///< whole axle at its static load, positive [N/rad]
  double cornering_stiffness_rear = 0.0;
  double slip_stiffness_ratio = 1.6;  ///< C_κ / C_α
  double tyre_shape = 1.35;
  double tyre_load_exponent = 0.8;
  double relaxation_length = 0.0;  ///< lateral; the longitudinal one is half of it [m]
  double tyre_damping = 0.0;       ///< of the stationary tyre, as a time [s]
  double friction = 1.0;
  std::vector<FrictionPatch> patches;  ///< a wheel has the friction of the first that contains it
  double rolling_resistance = 0.0;     ///< coefficient
  double drag = 0.0;                   ///< F = drag v² [N s²/m²]
  std::array<double, wheel_count> wheel_radius{};  ///< true effective radii [m]
  double wheel_inertia = 0.0;                      ///< [kg m²]
  double motor_inertia = 0.0;                      ///< added to each driven wheel [kg m²]
  double drive_front_share = 0.0;                  ///< 0: rear-wheel drive, 1: front-wheel drive
  double brake_front_share = 0.0;                  ///< of the braking force
  double torque_limit = 0.0;  ///< anti-lock and traction control, as a share of the grip; 0: none
  double roll_front_share = 0.5;     ///< of the lateral load transfer; rigid body
  double load_lag = 0.0;             ///< time constant of load transfer [s]
  double top_speed = 0.0;            ///< of the drive with free wheels [m/s]
  double drive_lag = 0.0;            ///< time constant of the drive force [s]
  double steering_delay = 0.0;       ///< dead time before the actuator [s]
  double steering_lag = 0.0;         ///< time constant of the actuator [s]
  double steering_rate_limit = 0.0;  ///< [rad/s]
  double steering_limit = 0.0;       ///< [rad]
  double rest_speed = 0.0;           ///< slower and not driven, the car comes to rest [m/s]
  Suspension suspension;             ///< none: the body is rigid

  /// Below this speed rolling resistance and brakes fade towards standstill [m/s].
  [[nodiscard]] double walking_speed() const { return 20.0 * rest_speed; }

  /// Inertia of a wheel, including its share of the motor [kg m²].
  [[nodiscard]] double spin_inertia(std::size_t wheel) const {
    const double share = wheel < rear_left ? drive_front_share : 1.0 - drive_front_share;
    return wheel_inertia + share * motor_inertia;
  }
};

struct PlantInput {
  double steering = 0.0;  ///< commanded mean angle of the front wheels [rad]
  double force = 0.0;     ///< requested at the wheels' circumference; brakes if opposite to v [N]
  RoadTilt road;          ///< for a car with a suspension
};

enum class Movement : std::uint8_t { rolling, resting };

class Plant {
 public:
  /// Starts at rest at this pose. Masses, lengths, stiffnesses, lags and limits must be positive.
  Plant(PlantParameters parameters, double x, double y, double yaw);

  /// Advances by one Runge-Kutta step of at most 1 ms.
  void step(const PlantInput& input, double dt);

  [[nodiscard]] const PlantOutput& output() const { return output_; }
  [[nodiscard]] Movement motion() const { return motion_; }

  /// Vertical load of each wheel [N].
  [[nodiscard]] std::array<double, wheel_count> loads() const { return loads(state_); }

  /// Sets the car in motion, straight ahead without slip.
  void set_speed(double v_x);

 private:
  /// Indices in the state, for each wheel with at().
  enum : std::size_t {
    pos_x,
    pos_y,
    heading,
    vel_x,
    vel_y,
    rate,
    steer,
    drive,
    shift_x,  ///< load-shifting accelerations
    shift_y,
    roll,
    roll_rate,
    pitch,
    pitch_rate,
    wheels_begin
  };
  enum : std::size_t { spin, turned, bend_x, bend_y };  ///< bend: the tyre's deflection
  static constexpr std::size_t per_wheel = 4;
  using State = std::array<double, wheels_begin + per_wheel * wheel_count>;
  static constexpr std::size_t at(std::size_t wheel, std::size_t what) {
    return wheels_begin + per_wheel * wheel + what;
  }

  struct Derivative {
    State rate{};
    double accel_x = 0.0, accel_y = 0.0;
  };
  struct GroundForces {
    double x = 0.0, y = 0.0, moment = 0.0;
  };

  struct WheelMotion;
  [[nodiscard]] WheelMotion wheel_motion(const State& state, std::size_t wheel) const;
  [[nodiscard]] static Attitude attitude(const State& s) {
    return {
        .roll = s[roll], .roll_rate = s[roll_rate], .pitch = s[pitch], .pitch_rate = s[pitch_rate]};
  }
  [[nodiscard]] Derivative derivative(const State& state, const PlantInput& input) const;
  [[nodiscard]] GroundForces wheel_forces(const State& state, State& rates) const;
  [[nodiscard]] double delayed(double steering, double dt);
  [[nodiscard]] std::array<double, wheel_count> loads(const State& state) const;
  [[nodiscard]] double friction_at(double x, double y) const;
  [[nodiscard]] double breakaway_force() const;
  void come_to_rest_or_go();
  void write_output(const PlantInput& input);

  PlantParameters parameters_;
  std::array<Tyre, wheel_count> tyres_;
  State state_{};
  RoadTilt road_;
  std::deque<double> commands_;  // steering commands, one per step, that are still delayed
  Movement motion_ = Movement::resting;
  PlantOutput output_;
};

// The cars of the simulation (cars.cpp), three of them full-size with published data: their
// configured and their true parameters.

/// The names of all cars for `--car`, separated by '|'.
[[nodiscard]] std::string car_names();

/// Throws std::invalid_argument with all names.
[[nodiscard]] CarKind find_car(std::string_view name);

[[nodiscard]] std::string_view car_name(CarKind car);

/// A sprung car with its published parameters, which its owner knows: cornering stiffnesses are
/// those of the tyres under the static load. All wheels have the published radius.
[[nodiscard]] PlantParameters published_car(CarKind car);

/// The configured car.
[[nodiscard]] estimator::Vehicle configured_vehicle(CarKind car);

/// The effective wheel radius with which the control units compute speeds [m].
[[nodiscard]] double configured_wheel_radius(CarKind car);

/// The simulated car: the configured one with the drawn errors of its tyres, mass and inertia, and
/// properties that are not in a configuration.
[[nodiscard]] PlantParameters true_vehicle(CarKind car, const ParameterSet& truth);

}  // namespace odomd::sim
