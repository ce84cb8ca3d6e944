// The driver: follows a track leg by leg from the true state, like a good controller, and holds the
// car in power slides.
#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <optional>
#include <vector>

#include "tools/sim/car/plant.hpp"
#include "tools/sim/course/track.hpp"

namespace odomd::sim {

/// In a power slide the throttle spins the rear wheels, whose grip is then spent, and the front
/// wheels, turned against the curve, keep the sideslip angle. What a slide is to follow:
struct SlideTarget {
  double sideslip = 0.0;   ///< β [rad], against the curve: negative in one to the left
  double curvature = 0.0;  ///< of the path [1/m], positive to the left
};

/// For a car with rear-wheel drive that slides through a curve.
[[nodiscard]] PlantInput hold_slide(const PlantParameters& car, const PlantOutput& now,
                                    const SlideTarget& target);

enum class Gear : std::uint8_t { forward, reverse };

/// From where the car stands along a track to `end`, and a stop there.
struct Leg {
  std::shared_ptr<const Track> track;
  double begin = 0.0;  ///< arc length of the rear axle at the start
  double end = 0.0;    ///< ... and at the stop; beyond the track's length: rounds
  double speed = 1.0;  ///< on straights [m/s]
  double pause = 1.0;  ///< stands so long afterwards [s]
  Gear gear = Gear::forward;
  double slide = 0.0;  ///< sideslip angle to hold in curves, by the throttle [rad]
};

/// How a drive begins and ends: standing, or at the planned speed.
enum class Ends : std::uint8_t { standing, moving };

/// How hard the driver drives.
struct DriverLimits {
  double lateral = 5.0;       ///< slows down for curves to this a_y [m/s²]
  double acceleration = 2.0;  ///< [m/s²]
  double deceleration = 2.0;  ///< [m/s²]
  double horizon = 0.45;      ///< comes back to the line within about so long [s]
};

class Driver {
 public:
  /// Waits for `wait` seconds before a standing start. A moving one needs routes of a single leg.
  Driver(PlantParameters car, std::vector<Leg> legs, const DriverLimits& limits, double wait,
         Ends ends = Ends::standing);

  /// What the driver wants now; `dt` since the last call.
  PlantInput drive(const PlantOutput& car, double dt);

  [[nodiscard]] bool done() const { return leg_ == legs_.size() && waited_ >= wait_; }

  /// So far off the track that there is no way back.
  [[nodiscard]] bool lost() const { return off_track_ > 5.0 * (car_.front_axle + car_.rear_axle); }

  /// Where on which track it is; there is one, whatever the time.
  [[nodiscard]] const Leg& leg() const { return legs_[std::min(leg_, legs_.size() - 1)]; }
  [[nodiscard]] double along_track() const { return s_; }

  /// Way driven along the legs and in all [m].
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
  [[nodiscard]] double path_curvature(const PlantOutput& car, double curvature, double reach) const;
  [[nodiscard]] double steering(const PlantOutput& car) const;
  [[nodiscard]] std::optional<PlantInput> slide(const PlantOutput& car, double dt);

  PlantParameters car_;
  std::vector<Leg> legs_;
  DriverLimits limits_;
  Ends ends_;
  double wait_;  // until the next leg, or until it is over
  double waited_ = 0.0;
  std::size_t leg_ = 0;
  double s_ = 0.0;             // of the rear axle along the leg's track
  double off_track_ = 0.0;     // distance of the rear axle from the track
  double wanted_speed_ = 0.0;  // ramped
  double steering_ = 0.0;
  double sideslip_ = 0.0;         // to hold in a slide, ramped [rad]
  double slide_curvature_ = 0.0;  // of the curve that it slides through
  double finished_ = 0.0;
  double total_ = 0.0;
  std::vector<double> plan_;  // v² at the track's samples, braking before curves included
};

/// The pose of a car that stands on a track with its rear axle, ready to drive.
[[nodiscard]] TrackPoint standing_pose(const PlantParameters& car, const Leg& leg);

}  // namespace odomd::sim
