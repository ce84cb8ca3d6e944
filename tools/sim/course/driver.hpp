// The driver: follows a track leg by leg from the true state, as a good controller would, and holds
// the car in power slides. Also the scenarios, which say what it drives.
#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <span>
#include <string_view>
#include <vector>

#include "tools/sim/car/parameters.hpp"
#include "tools/sim/car/plant.hpp"
#include "tools/sim/course/track.hpp"

namespace odomd::sim {

enum class Gear : std::uint8_t { forward, reverse };

/// A drive from the car's position along a track to `end`, with a stop there.
struct Leg {
  std::shared_ptr<const Track> track;
  double begin = 0.0;  ///< arc length of the rear axle at the start
  double end = 0.0;    ///< arc length at the stop; beyond the track's length: several rounds
  double speed = 1.0;  ///< on straights [m/s]
  double pause = 1.0;  ///< standstill after the leg [s]
  Gear gear = Gear::forward;
  double slide = 0.0;  ///< sideslip angle to hold in curves with the throttle [rad]
};

/// Whether a drive begins and ends at standstill or at the planned speed.
enum class Ends : std::uint8_t { standing, moving };

/// Limits of the driver.
struct DriverLimits {
  double lateral = 5.0;       ///< brakes for curves to this a_y [m/s²]
  double acceleration = 2.0;  ///< [m/s²]
  double deceleration = 2.0;  ///< [m/s²]
  double horizon = 0.45;      ///< time constant of the return to the line, roughly [s]
};

class Driver {
 public:
  /// Waits for `wait` seconds before a standing start. A moving start needs a single leg.
  Driver(PlantParameters car, std::vector<Leg> legs, const DriverLimits& limits, double wait,
         Ends ends = Ends::standing);

  /// The driver's input now; `dt` since the last call.
  PlantInput drive(const PlantOutput& car, double dt);

  [[nodiscard]] bool done() const { return leg_ == legs_.size() && waited_ >= wait_; }

  /// Whether the car is too far off the track to return.
  [[nodiscard]] bool lost() const { return off_track_ > 5.0 * (car_.front_axle + car_.rear_axle); }

  /// The current leg and the position along its track; after the end, those of the last leg.
  [[nodiscard]] const Leg& leg() const { return legs_[std::min(leg_, legs_.size() - 1)]; }
  [[nodiscard]] double along_track() const { return s_; }

  /// Distance driven along the legs, and the length of all legs [m].
  [[nodiscard]] double progress() const {
    return finished_ + (leg_ < legs_.size() ? s_ - legs_[leg_].begin : 0.0);
  }
  [[nodiscard]] double total() const { return total_; }

  /// Speed of the car at the start, along its leg [m/s].
  [[nodiscard]] double start_speed() const {
    return ends_ == Ends::moving ? planned_speed(legs_.front().begin) : 0.0;
  }

 private:
  void begin_leg();
  [[nodiscard]] double planned_speed(double s) const;
  [[nodiscard]] double path_curvature(const PlantOutput& car, Vector2 rear, double curvature,
                                      double reach) const;
  [[nodiscard]] double steering(const PlantOutput& car, Vector2 rear) const;
  [[nodiscard]] std::optional<PlantInput> slide(const PlantOutput& car, Vector2 rear, double dt);

  PlantParameters car_;
  std::vector<Leg> legs_;
  DriverLimits limits_;
  Ends ends_;
  double wait_;  // standstill before the next leg, or before the end [s]
  double waited_ = 0.0;
  std::size_t leg_ = 0;
  double s_ = 0.0;             // of the rear axle along the leg's track
  double off_track_ = 0.0;     // distance of the rear axle from the track
  double wanted_speed_ = 0.0;  // after ramping
  double steering_ = 0.0;
  double sideslip_ = 0.0;         // current target in a slide, ramped [rad]
  double slide_curvature_ = 0.0;  // of the curve of the current slide
  double finished_ = 0.0;
  double total_ = 0.0;
  std::vector<double> plan_;  // v² at the track's samples, including braking before curves
};

/// The pose of a stationary car with its rear axle on a track, ready to drive.
[[nodiscard]] TrackPoint standing_pose(const PlantParameters& car, const Leg& leg);

// The scenarios: car, route, speed, and patches on the road.

/// The route of a drive.
struct Route {
  std::vector<Leg> legs;
  std::vector<FrictionPatch> patches;  ///< with the friction from the parameters
};

struct Scenario {
  std::string_view name;
  std::string_view sentence;
  CarKind car = CarKind::scale_car;  ///< default; other cars of its size are allowed
  double speed = 1.0;                ///< default [m/s]
  double max_speed = 3.0;
  int laps = 1;  ///< default
  DriverLimits limits;
  std::function<Route(double speed, int laps)> route;
  double grade = 0.0;  ///< default of the parameter road_grade [1]
  double bank = 0.0;   ///< default of the parameter road_bank [rad]
};

[[nodiscard]] std::span<const Scenario> all_scenarios();

/// The first scenario with this name (if `size` is given, among those for cars of this size).
/// Throws std::invalid_argument with all names.
[[nodiscard]] const Scenario& find_scenario(std::string_view name,
                                            std::optional<CarSize> size = {});

}  // namespace odomd::sim
