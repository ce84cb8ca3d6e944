#include "tools/sim/simulation.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <stdexcept>
#include <string>

#include "tools/sim/car/plant.hpp"

namespace odomd::sim {
namespace {

constexpr std::int64_t driver_period_ns = 10'000'000;
constexpr double max_duration_s = 86'400.0;
constexpr int max_laps = 10'000;

tools::TrajectoryPoint truth_row(std::int64_t time_ns, const PlantOutput& car) {
  return {time_ns, {car.x, car.y, car.yaw}, {car.v_x, car.v_y, car.yaw_rate}};
}

double route_length(const Route& route) {
  double length = 0.0;
  for (const Leg& leg : route.legs) length += leg.end - leg.begin;
  return length;
}

// Time limit of the run: enough for the whole route at a tenth of the planned speed [ns].
std::int64_t deadline(const RunPlan& plan) {
  double seconds = plan.options.standstill + 60.0;
  for (const Leg& leg : plan.route.legs)
    seconds += leg.pause + 10.0 * (leg.end - leg.begin) / leg.speed + 10.0;
  return std::llround(1e9 * seconds);
}

// Applies `shift` to the leading elements for which `has_come` is true, and moves them to `to`.
template <class T, class Test, class Shift>
void hand_over(std::vector<T>& from, std::vector<T>& to, Test has_come, Shift shift) {
  const auto end = std::ranges::find_if_not(from, has_come);
  std::for_each(from.begin(), end, shift);
  to.insert(to.end(), from.begin(), end);
  from.erase(from.begin(), end);
}

}  // namespace

RunPlan make_plan(const RunOptions& options) {
  const auto of_size = options.car ? std::optional(size_of(*options.car)) : std::nullopt;
  RunPlan plan{.options = options, .scenario = find_scenario(options.scenario, of_size)};
  const Scenario& scenario = plan.scenario;
  plan.car_kind = options.car.value_or(scenario.car);

  plan.speed = options.speed.value_or(scenario.speed);
  if (!(plan.speed >= 0.1 && plan.speed <= scenario.max_speed))
    throw std::invalid_argument("speed: scenario " + options.scenario + " takes 0.1 to " +
                                std::to_string(scenario.max_speed).substr(0, 4) + " m/s");
  if (!(options.standstill >= 0.0 && options.standstill <= max_duration_s))
    throw std::invalid_argument("standstill: must lie between 0 and 86400 s");
  if (options.duration && !(*options.duration > 0.0 && *options.duration <= max_duration_s))
    throw std::invalid_argument("duration: must lie between 0 and 86400 s");
  if (options.laps && (*options.laps < 1 || *options.laps > max_laps))
    throw std::invalid_argument("laps: must lie between 1 and 10000");
  if (options.start_ns < 0) throw std::invalid_argument("start time: must not be negative");

  plan.laps = options.laps.value_or(scenario.laps);
  if (options.duration && !options.laps) {  // as many laps as fit into the duration
    const double lap = route_length(scenario.route(plan.speed, 1));
    plan.laps =
        static_cast<int>(std::min(*options.duration * plan.speed / lap + 1.0, double{max_laps}));
  }

  plan.sizes = default_parameters(plan.car_kind);
  plan.sizes[Parameter::road_grade] = scenario.grade;
  plan.sizes[Parameter::road_bank] = scenario.bank;
  if (options.errors == ErrorModel::ideal) make_ideal(plan.sizes);
  for (const Assignment& size : options.sizes) {
    check(parameter_table()[static_cast<std::size_t>(size.parameter)], size.value);
    plan.sizes[size.parameter] = size.value;
  }
  plan.truth = draw_truth(plan.sizes, options.seed);
  for (const Assignment& fixed : options.fixed) {
    const ParameterInfo& info = parameter_table()[static_cast<std::size_t>(fixed.parameter)];
    check(info, info.draw == Draw::exact ? fixed.value : std::abs(fixed.value));
    plan.truth[fixed.parameter] = fixed.value;
    if (info.draw == Draw::exact) plan.sizes[fixed.parameter] = fixed.value;
  }

  if (plan.truth[Parameter::camera_latency_max] < plan.truth[Parameter::camera_latency_min])
    throw std::invalid_argument("camera_latency_max: must not be less than camera_latency_min");

  plan.route = scenario.route(plan.speed, plan.laps);
  if (options.ends == Ends::moving && plan.route.legs.size() > 1)
    throw std::invalid_argument("moving start: scenario " + options.scenario +
                                " stops on its way; choose another, such as lap");
  plan.length = route_length(plan.route);
  for (FrictionPatch& patch : plan.route.patches)
    patch.friction = plan.truth[Parameter::patch_friction];
  plan.car = true_vehicle(plan.car_kind, plan.truth);
  plan.car.patches = plan.route.patches;
  plan.start = standing_pose(plan.car, plan.route.legs.front());
  return plan;
}

Simulation::Simulation(const RunPlan& plan)
    : start_ns_(plan.options.start_ns),
      end_ns_(plan.options.duration ? std::llround(1e9 * *plan.options.duration)
                                    : std::numeric_limits<std::int64_t>::max()),
      deadline_ns_(deadline(plan)),
      plant_(plan.car, plan.start.x, plan.start.y, plan.start.heading),
      driver_(plan.car, plan.route.legs, plan.scenario.limits, plan.options.standstill,
              plan.options.ends),
      bus_(plan.truth, configured_wheel_radius(plan.car_kind), plan.options.seed),
      camera_(plan.truth, plan.options.dropouts, plan.options.seed),
      film_(plan.car_kind, plan.truth, plan.options.seed),
      road_{.grade = plan.truth[Parameter::road_grade], .bank = plan.truth[Parameter::road_bank]} {
  if (plan.options.ends == Ends::moving) plant_.set_speed(driver_.start_speed());
}

// The road's tilt in the direction of the car, which may drive along the track in reverse.
RoadTilt Simulation::road_here(std::int64_t since_ns) const {
  const Leg& leg = driver_.leg();
  const double side = leg.gear == Gear::reverse ? -1.0 : 1.0;
  const double speed = plant_.output().v_x;
  const double s = driver_.along_track() + side * speed * 1e-9 * static_cast<double>(since_ns);
  const RoadTilt along = tilt_at(road_, *leg.track, s, side * speed);
  return {side * along.grade, side * along.bank, side * along.grade_rate, side * along.bank_rate};
}

RunState Simulation::advance(std::int64_t time_ns, Happenings& happenings) {
  RunState state = RunState::running;
  if (now_ns_ == 0) happenings.truth.push_back(truth_row(start_ns_, plant_.output()));
  while (now_ns_ < time_ns) {
    if (now_ns_ >= end_ns_ || driver_.done()) {
      state = RunState::ended;
      break;
    }
    if (driver_.lost() || now_ns_ > deadline_ns_)
      throw std::runtime_error(std::string(driver_.lost() ? "the car has left its track after "
                                                          : "the car is stuck after ") +
                               std::to_string(now_ns_ / 1'000'000'000) +
                               " s; drive slower, or give it more grip");
    if (now_ns_ % driver_period_ns == 0)
      input_ = driver_.drive(plant_.output(), 1e-9 * double{driver_period_ns});
    if (!road_.is_level()) input_.road = road_here(now_ns_ % driver_period_ns);
    const PlantOutput before = plant_.output();
    plant_.step(input_, 1e-9 * double{plant_step_ns});
    const std::int64_t from_ns = now_ns_;
    now_ns_ += plant_step_ns;
    bus_.advance(from_ns, before, now_ns_, plant_.output(), frames_);
    camera_.advance(from_ns, before, now_ns_, plant_.output(), camera_poses_);
    film_.advance(from_ns, before, now_ns_, plant_.output(), happenings.film);
    if (now_ns_ % truth_period_ns == 0)
      happenings.truth.push_back(truth_row(start_ns_ + now_ns_, plant_.output()));
  }
  // Frames and poses that have not been received yet stay for later.
  hand_over(
      frames_, happenings.frames,
      [this](const can::Frame& frame) { return frame.time_ns <= now_ns_; },
      [this](can::Frame& frame) { frame.time_ns += start_ns_; });
  hand_over(
      camera_poses_, happenings.camera,
      [this](const estimator::CameraPose& pose) { return pose.arrival_ns <= now_ns_; },
      [this](estimator::CameraPose& pose) {
        pose.capture_ns += start_ns_;
        pose.arrival_ns += start_ns_;
      });
  return state;
}

}  // namespace odomd::sim
