// One run: the car, its driver, its bus and the camera, from rest to rest or always moving.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "can_protocol/frame.hpp"
#include "estimator/common/measurement.hpp"
#include "tools/drive_files/trajectory.hpp"
#include "tools/sim/car/parameters.hpp"
#include "tools/sim/car/plant.hpp"
#include "tools/sim/car_bus.hpp"
#include "tools/sim/course/driver.hpp"
#include "tools/sim/course/track.hpp"
#include "tools/sim/sensors/sensors.hpp"

namespace odomd::sim {

enum class ErrorModel : std::uint8_t { realistic, ideal };

/// What to simulate. Options without a value take the scenario's value.
struct RunOptions {
  std::string scenario = "lap";
  std::optional<CarKind> car;
  std::optional<double> speed;  ///< [m/s]
  std::optional<int> laps;
  std::optional<double> duration;  ///< the run ends then, wherever the car is [s]
  double standstill = 3.0;         ///< time before the car starts to move [s]
  Ends ends = Ends::standing;      ///< moving: without any standstill
  std::uint64_t seed = 1;
  ErrorModel errors = ErrorModel::realistic;
  std::vector<Assignment> sizes;  ///< replace the default sizes
  std::vector<Assignment> fixed;  ///< truths that are set, not drawn
  std::vector<Dropout> dropouts;
  std::int64_t start_ns = 1'760'000'000'000'000'000;  ///< log time of the start
};

/// The resolved options, and the drawn truth.
struct RunPlan {
  RunOptions options;
  Scenario scenario;
  CarKind car_kind = CarKind::scale_car;
  double speed = 0.0;
  int laps = 0;
  ParameterSet sizes;
  ParameterSet truth;
  Route route;
  PlantParameters car;  ///< with its true parameters
  TrackPoint start;     ///< pose of the centre of gravity
  double length = 0.0;  ///< of the route [m]
};

/// Throws std::invalid_argument for inconsistent options.
[[nodiscard]] RunPlan make_plan(const RunOptions& options);

/// The results of a stretch of time on the log's clock, each in the order of its times (frames:
/// stamps; camera poses: arrival).
struct Happenings {
  std::vector<can::Frame> frames;
  std::vector<estimator::CameraPose> camera;
  std::vector<tools::TrajectoryPoint> truth;
  std::vector<FilmFrame> film;
};

/// Time between two rows of the truth, and between two ticks of a daemon.
inline constexpr std::int64_t truth_period_ns = 5'000'000;

/// Integration step.
inline constexpr std::int64_t plant_step_ns = 500'000;

enum class RunState : std::uint8_t { running, ended };

class Simulation {
 public:
  explicit Simulation(const RunPlan& plan);

  /// Advances to `time_ns` after the start, a multiple of plant_step_ns, and appends the results.
  /// Throws std::runtime_error if the car has left its track or is stuck.
  RunState advance(std::int64_t time_ns, Happenings& happenings);

  [[nodiscard]] std::int64_t time_ns() const { return now_ns_; }
  [[nodiscard]] const Plant& plant() const { return plant_; }
  [[nodiscard]] const Driver& driver() const { return driver_; }

 private:
  [[nodiscard]] RoadTilt road_here(std::int64_t since_ns) const;

  std::int64_t start_ns_;
  std::int64_t end_ns_;
  std::int64_t deadline_ns_;
  std::int64_t now_ns_ = 0;
  Plant plant_;
  Driver driver_;
  CarBus bus_;
  Camera camera_;
  Film film_;
  RoadProfile road_;
  PlantInput input_;
  std::vector<can::Frame> frames_;                   // sent, but not yet received
  std::vector<estimator::CameraPose> camera_poses_;  // taken, but not yet arrived
};

}  // namespace odomd::sim
