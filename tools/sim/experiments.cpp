#include "tools/sim/drive_folder.hpp"

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>
#include <numbers>
#include <stdexcept>
#include <vector>

#include "tools/cli/files.hpp"
#include "tools/sim/car/plant.hpp"
#include "tools/sim/car/swing.hpp"
#include "tools/sim/car_bus.hpp"

namespace odomd::sim {
namespace {

using Json = nlohmann::ordered_json;
using std::numbers::pi;

/// Rounded as in a reading, without errors of binary fractions: 2.929, not 2.9290000000000003.
double rounded(double value, double step) {
  return std::round(value / step) / std::round(1.0 / step);
}

/// A length that a person measures: the truth with an error of this sigma, rounded to the step.
/// Measurements have the names of the options of odom identify.
void measure(Json& result, const std::string& name, double truth, double sigma, double step,
             RandomStream& hand) {
  result[name] = rounded(truth + sigma * hand.normal(), step);
  result[name + "_sigma"] = std::hypot(sigma, step / std::sqrt(12.0));
}

/// The kitchen scale. All experiments of a seed use the same scale, so that their readings of a
/// load agree. Readings scatter by half of the last digit, as odom identify assumes if only the
/// resolution of a scale is known.
struct KitchenScale {
  static constexpr double resolution = 1e-3;         // kg
  static constexpr double sigma = 0.5 * resolution;  // of the readings, including rounding
  static constexpr double accuracy = 1e-3;           // of the scale's gain

  double gain;

  [[nodiscard]] double read(double load, RandomStream& hand) const {
    const double placing = std::sqrt(sigma * sigma - resolution * resolution / 12.0);
    return rounded(gain * load + placing * hand.normal(), resolution);
  }
};

void write_json(const std::filesystem::path& file, const Json& json) {
  tools::write_whole(file, json.dump(2) + '\n');
}

/// plant.json: the car's part of a drive's plant.json, and the truth of the experiment.
void write_truth(const ExperimentOptions& options, const RunPlan& plan, const char* experiment,
                 const Json& truth) {
  Json plant = describe(plan);
  plant["scenario"] = experiment;
  for (const char* key :
       {"speed", "laps", "standstill", "moving_start", "route_length", "start_pose"})
    plant.erase(key);
  plant["experiment"] = truth;
  write_json(options.folder / "plant.json", plant);
}

/// Three consecutive stop-watch timings of 20 full swings, triggered as the car passes the middle
/// in one direction.
void time_swings(Json& result, const std::vector<double>& passages, double sigma,
                 RandomStream& stream) {
  constexpr std::size_t swings = 20, timings = 3;
  Json times = Json::array();
  for (std::size_t i = 0; i < timings; ++i) {
    const std::size_t from = 1 + i * swings;
    if (from + swings >= passages.size()) break;
    const double time = passages[from + swings] - passages[from] +
                        sigma / std::sqrt(2.0) * (stream.normal() - stream.normal());
    times.push_back(rounded(time, 0.01));
  }
  result["swings"] = swings;
  result["time"] = times;
  result["time_sigma"] = sigma;
}

}  // namespace

nlohmann::ordered_json simulate_swing(const ExperimentOptions& options) {
  if (!(options.duration >= 20.0 && options.duration <= 3600.0))
    throw std::invalid_argument("--duration: a swing takes 20 to 3600 s");
  const RunPlan plan = make_plan({.seed = options.seed});
  RandomStream draw(options.seed, "the swing");
  SwingParameters rig;
  rig.mass = plan.car.mass;
  rig.inertia = {0.3 * plan.car.yaw_inertia, 0.9 * plan.car.yaw_inertia, plan.car.yaw_inertia};
  rig.gravity = 9.806 + 0.01 * draw.normal();
  rig.spacing_above = draw.uniform(0.18, 0.26);
  rig.spacing_below = rig.spacing_above + 0.002 * draw.normal();
  rig.cord = draw.uniform(0.8, 1.5);
  rig.stretch = draw.uniform(0.5e-3, 2e-3);
  rig.offset_along = 0.003 * draw.normal();
  rig.height_of_attachment = draw.uniform(0.03, 0.06);
  // Levelled by eye to 1.5°: the car hangs with its centre of gravity below the cords.
  rig.offset_across = rig.height_of_attachment * 1.5 * pi / 180.0 * draw.normal();
  // The amplitude falls by 0.3 to 1.7 % per swing, partly from drag that grows with speed.
  const double omega = std::sqrt(rig.mass * rig.gravity * rig.spacing_above * rig.spacing_above /
                                 (4.0 * rig.cord * plan.car.yaw_inertia));
  rig.viscous = draw.uniform(0.003, 0.008) * omega * plan.car.yaw_inertia / pi;
  rig.quadratic = draw.uniform(0.0, 0.01) * plan.car.yaw_inertia;
  rig.sway_drag = 0.03 * rig.mass;
  rig.amplitude = draw.uniform(10.0, 20.0) * pi / 180.0;
  rig.push = 0.01 * draw.normal();

  make_drive_folder(options.folder, options.existing);
  write_car_files(options.folder, plan, {});
  DriveWriter writer(options.folder, log_interface);
  CarBus bus(plan.truth, configured_wheel_radius(plan.car_kind), options.seed);

  constexpr std::int64_t held_ns = 2'000'000'000;
  const std::int64_t end_ns = held_ns + std::llround(1e9 * options.duration);
  SwingRig car(rig);
  Happenings happenings;
  std::vector<double> passages;  // times of passing the middle towards positive yaw
  std::vector<double> turns;     // largest deflection before each passage
  double widest = 0.0;
  for (std::int64_t now = 0; now < end_ns; now += plant_step_ns) {
    const PlantOutput before = car.output();
    if (now % truth_period_ns == 0)
      happenings.truth.push_back({plan.options.start_ns + now,
                                  {before.x, before.y, before.yaw},
                                  {before.v_x, before.v_y, before.yaw_rate}});
    if (now >= held_ns) car.step(seconds(plant_step_ns));
    const PlantOutput& after = car.output();
    bus.advance(now, before, now + plant_step_ns, after, happenings.frames);
    widest = std::max(widest, std::fabs(after.yaw));
    if (before.yaw < 0.0 && after.yaw >= 0.0) {
      passages.push_back(seconds(now + plant_step_ns));
      turns.push_back(widest);
      widest = 0.0;
    }
  }
  std::ranges::stable_sort(happenings.frames, {}, &can::Frame::time_ns);
  for (can::Frame& frame : happenings.frames) frame.time_ns += plan.options.start_ns;
  writer.write(happenings);
  writer.close();

  write_truth(options, plan, "swing",
              {{"mass", rig.mass},
               {"yaw_inertia", plan.car.yaw_inertia},
               {"gravity", rig.gravity},
               {"spacing", rig.spacing_above},
               {"spacing_below", rig.spacing_below},
               {"cord", rig.cord},
               {"offset_along", rig.offset_along},
               {"offset_across", rig.offset_across},
               {"amplitude", rig.amplitude}});

  RandomStream hand(options.seed, "who measures the swing");
  Json result;
  measure(result, "spacing", rig.spacing_above, 4e-4, 5e-4, hand);
  measure(result, "spacing_below", rig.spacing_below, 4e-4, 5e-4, hand);
  result.erase("spacing_below_sigma");  // spacing_sigma applies to both
  measure(result, "cord", rig.cord, 1.5e-3, 1e-3, hand);
  result["offset_sigma"] = 0.003;
  result["amplitude"] = rig.amplitude * (1.0 + 0.1 * hand.normal());
  time_swings(result, passages, 0.12, hand);
  const double last = turns.at(std::min<std::size_t>(61, turns.size() - 1));
  result["amplitude_end"] =
      std::min(last * (1.0 + 0.1 * hand.normal()), result["amplitude"].get<double>());
  write_json(options.folder / "measured.json", result);
  return result;
}

nlohmann::ordered_json simulate_weighing(const ExperimentOptions& options) {
  const RunPlan plan = make_plan({.seed = options.seed});
  RandomStream draw(options.seed, "the weighing");
  const double mass = plan.car.mass;
  const double wheelbase = plan.car.front_axle + plan.car.rear_axle;
  const double track = plan.car.track_width;
  const double front_axle = plan.car.front_axle;
  const double lateral = 2e-3 * draw.normal();
  const double height = draw.uniform(0.2, 0.3) * wheelbase;
  const KitchenScale scale{1.0 + KitchenScale::accuracy *
                                     RandomStream(options.seed, "the scale").normal()};
  const double level = 0.25 * pi / 180.0;

  make_drive_folder(options.folder, options.existing);
  write_car_files(options.folder, plan, {});
  write_truth(options, plan, "weighing",
              {{"mass", mass},
               {"wheelbase", wheelbase},
               {"front_axle", front_axle},
               {"rear_axle", plan.car.rear_axle},
               {"track_width", track},
               {"lateral", lateral},
               {"height", height},
               {"scale_gain", scale.gain}});

  RandomStream hand(options.seed, "who weighs");
  Json measured;
  // On a slope, the weight's line of action is shifted by height × slope.
  const auto weigh = [&](const char* name, double share_on_the_level, double base) {
    const double load =
        mass *
        (share_on_the_level + (base > 0.0 ? height * std::tan(level * hand.normal()) / base : 0.0));
    for (int i = 0; i < 3; ++i) measured[name].push_back(scale.read(load, hand));
  };
  weigh("total", 1.0, 0.0);
  weigh("front", 1.0 - front_axle / wheelbase, wheelbase);
  weigh("rear", front_axle / wheelbase, wheelbase);
  weigh("left", 0.5 + lateral / track, track);
  weigh("right", 0.5 - lateral / track, track);
  measured["scale_resolution"] = KitchenScale::resolution;
  measured["scale_sigma"] = KitchenScale::sigma;
  measured["scale_accuracy"] = KitchenScale::accuracy;
  measured["level"] = level;
  measure(measured, "wheelbase", wheelbase, 5e-4, 5e-4, hand);
  measure(measured, "track_width", track, 5e-4, 5e-4, hand);
  write_json(options.folder / "measured.json", measured);
  return measured;
}

}  // namespace odomd::sim
