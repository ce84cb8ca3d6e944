// Checks the configuration: that it has the roles which the model needs, that the window covers the
// latency of every sample, and that the numbers are plausible. Builds the settings of the filter.
#include <algorithm>
#include <cmath>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include <fmt/format.h>
#include <fmt/ranges.h>

#include "daemon/core/config_sections.hpp"
#include "daemon/diagnostics/diagnostic.hpp"
#include "estimator/common/tuning.hpp"
#include "estimator/ekf/sample_window.hpp"

namespace odomd::daemon {
namespace {

using diagnostics::found;
using diagnostics::kind;
using estimator::index_of;
using estimator::Model;
using estimator::Source;
using estimator::full::SampleWindow;

/// Warns if steering or gyro is not mapped, with the sources that still measure turns.
void warn_of_turns(const Config& config, diagnostics::Diagnostics& warnings) {
  std::vector<std::string_view> missing, others;
  for (const auto& [source, name] :
       {std::pair{Source::steering, "steering"}, {Source::yaw_rate, "yaw_rate"}})
    (is_mapped(config, source) ? others : missing).push_back(name);
  if (missing.empty()) return;
  // A single wheel of an axle shows no turn.
  if (std::ranges::any_of(estimator::wheel_pairs, [&](const auto& pair) {
        return is_mapped(config, pair.first) && is_mapped(config, pair.second);
      }))
    others.push_back("the wheels");
  warnings.push_back(found(
      kind("role_not_mapped"), config.file.string() + ": [can.signals]",
      fmt::format(
          "{} {} not mapped: {}", fmt::join(missing, " and "), missing.size() > 1 ? "are" : "is",
          others.empty()
              ? "nothing measures how the car turns, and the pose goes straight "
                "ahead between camera poses"
              : fmt::format("only {} measure{} how the car turns", fmt::join(others, " and "),
                            others.size() > 1 || others[0] == "the wheels" ? "" : "s"))));
}

/// Checks that a speed is mapped, and warns of what the model does without the other roles.
void check_roles(const Config& config, diagnostics::Diagnostics& warnings) {
  if (std::ranges::none_of(estimator::wheel_sources,
                           [&](Source source) { return is_mapped(config, source); }))
    throw ConfigError(fmt::format(
        "{}: [can.signals]: no speed is mapped; map wheel_rear, the four wheels or motor",
        config.file.string()));
  require_roles(config);
  const auto warn = [&](Source source, std::string_view without) {
    if (!is_mapped(config, source))
      warnings.push_back(found(
          kind("role_not_mapped"), config.file.string() + ": [can.signals]",
          fmt::format("{} is not mapped: {}", estimator::source_names[index_of(source)], without)));
  };
  const bool full = config.model == Model::full;
  if (full) {
    warn_of_turns(config, warnings);
  } else if (config.model != Model::inertial) {
    warn(Source::steering, "the filter assumes that the car steers straight ahead");
  }
  if (config.model == Model::paper) warn(Source::yaw_rate, "the filter assumes that it measures 0");
  const estimator::SteeringActuator& actuator = config.vehicle.steering;
  if (full && !is_mapped(config, Source::steering) &&
      (actuator.delay_s > 0.0 || actuator.lag_s > 0.0 || actuator.rate_limit > 0.0))
    warnings.push_back(found(kind("actuator_without_steering"),
                             config.file.string() + ": [steering]",
                             "steering is not mapped, so this table has no effect"));
}

/// Checks that both axes of the accelerometer are mapped alike: they can only be rotated together.
void check_mounting(const Config& config) {
  if (config.imu_yaw == 0.0) return;
  const can::SignalBinding* const along = binding_of(config, Source::accel_x);
  const can::SignalBinding* const across = binding_of(config, Source::accel_y);
  if (along == nullptr && across == nullptr) return;
  const auto fail = [&](std::string_view what) {
    throw ConfigError(fmt::format("{}: [imu] yaw: accel_x and accel_y are rotated together: {}",
                                  config.file.string(), what));
  };
  if (along == nullptr) fail("map accel_x too, or leave yaw out");
  if (across == nullptr) fail("map accel_y too, or leave yaw out");
  if (along->message != across->message || along->bus != across->bus)
    fail("take both from one message on one bus, or leave yaw out");
  if (along->latency_ns != across->latency_ns) fail("give both the same latency");
}

/// Checks the latencies: samples older than the window are never fused.
void check_window(const Config& config) {
  if (config.model != Model::full) return;
  const auto fail = [&](const std::string& key, double latency, std::string_view what,
                        std::string_view lower) {
    throw ConfigError(fmt::format(
        "{}: {}: {} s is longer than [filter] window, {} s: {} that old would never be fused; {}{}",
        config.file.string(), key, latency, config.window_s, what,
        latency <= longest_window_s ? fmt::format("set window to at least {}, or ", latency) : "",
        lower));
  };
  for (const auto& binding : config.can.bindings) {
    const double latency = static_cast<double>(binding.latency_ns) / 1e9;
    if (latency > config.window_s)
      fail(fmt::format("[can.signals] {} latency", binding.role), latency, "samples",
           "correct the latency");
  }
  if (config.camera.max_latency_s > config.window_s)
    fail("[camera] max_latency", config.camera.max_latency_s, "poses", "lower max_latency");
}

/// Warns of numbers that no car has, usually because they are in another unit. The checks use
/// ratios, which hold for a model car and for a lorry, with wide ranges, so that unusual cars are
/// accepted.
void check_vehicle(const Config& config, diagnostics::Diagnostics& warnings) {
  const estimator::Vehicle& car = config.vehicle;
  const double base = car.wheelbase();
  const auto check = [&](const diagnostics::Kind& kind, double value, const std::string& seen) {
    if (!kind.limits.hold(value))
      warnings.push_back(found(kind, config.file.string() + ": [vehicle]", seen));
  };
  check(kind("mass_unlike_a_car"), car.mass / (base * base * base),
        fmt::format("{} kg on a wheelbase of {} m does not fit a car", car.mass, base));
  const double inertia = car.yaw_inertia / (car.mass * car.front_axle * car.rear_axle);
  check(kind("inertia_unlike_a_car"), inertia,
        fmt::format("yaw_inertia {} is {:.2g} times mass·front_axle·rear_axle; for cars this "
                    "factor is about 1",
                    car.yaw_inertia, inertia));
  check(kind("track_unlike_a_car"), car.track_width / base,
        fmt::format("track_width {} m on a wheelbase of {} m does not fit a car", car.track_width,
                    base));
  for (const auto& [key, value] :
       {std::pair{"cornering_stiffness_front", car.cornering_stiffness_front},
        std::pair{"cornering_stiffness_rear", car.cornering_stiffness_rear}}) {
    const double share = value / (car.mass * estimator::gravity);
    check(kind("stiffness_unlike_a_tyre"), share,
          fmt::format("{} {} is {:.2g} times the car's weight per radian; for tyres this factor is "
                      "0.5 to 10",
                      key, value, share));
  }
  for (const auto& [key, value] :
       {std::pair{"grip_front", car.grip_front}, std::pair{"grip_rear", car.grip_rear}})
    if (value > 0.0)
      check(kind("grip_unlike_a_tyre"), value,
            fmt::format("{} {} is out of range for a tyre; on a road it is 5 to 15", key, value));
}

}  // namespace

void require_roles(const Config& config) {
  if (config.model == Model::inertial && !is_mapped(config, Source::yaw_rate))
    throw ConfigError(fmt::format(
        "{}: [can.signals]: yaw_rate is not mapped, but the model inertial takes its heading from "
        "the gyro only; map yaw_rate, or choose another model, such as full",
        config.file.string()));
}

void check_model(const Config& config, diagnostics::Diagnostics& warnings) {
  check_roles(config, warnings);
  check_mounting(config);
  check_window(config);
  check_sizes(config, warnings);
}

void check_sizes(const Config& config, diagnostics::Diagnostics& warnings) {
  check_vehicle(config, warnings);
  const double base = config.vehicle.wheelbase();
  const auto check = [&](const std::string& key, double x, double y) {
    const double wheelbases = std::hypot(x, y) / base;
    if (!kind("sensor_outside_car").limits.hold(wheelbases))
      warnings.push_back(
          found(kind("sensor_outside_car"), config.file.string() + ": " + key,
                fmt::format("[{}, {}] is {:.2g} wheelbases from the centre of gravity", x, y,
                            wheelbases)));
  };
  check("[camera] lever_arm", config.camera.lever_arm[0], config.camera.lever_arm[1]);
  if (const auto& arm = config.reference_lever_arm)
    check("[reference] lever_arm", (*arm)[0], (*arm)[1]);
  check("[imu] position", config.imu_position[0], config.imu_position[1]);
}

void check_rates(const Config& config, std::span<const can::BoundMessage> messages,
                 diagnostics::Diagnostics& warnings) {
  if (config.model != Model::full) return;
  // Samples are kept for one tick and 1.5 windows, since learnt latencies move a sample earlier by
  // up to half a window.
  constexpr double windows = 1.5;
  const double tick_s = static_cast<double>(config.realtime.period_ns) * 1e-9;
  const double kept_s = windows * config.window_s + tick_s;
  double samples = 0.0;
  for (const auto& message : messages)
    if (message.cycle_time_ns > 0)
      samples += static_cast<double>(message.channels.size()) * kept_s * 1e9 /
                 static_cast<double>(message.cycle_time_ns);
  const double longest_s =
      (kept_s * static_cast<double>(SampleWindow::capacity) / samples - tick_s) / windows;
  if (longest_s < config.window_s)
    warnings.push_back(found(
        kind("window_overflows"), config.file.string() + ": [filter] window",
        fmt::format(
            "{:.0f} samples come in {} s (a window and a half) and one tick at the databases' "
            "cycle times, but only {} fit: the effective window is shorter",
            samples, windows * config.window_s, SampleWindow::capacity),
        fmt::format("{:.2g} s",
                    std::max(shortest_window_s, std::floor(100.0 * longest_s) / 100.0))));
}

estimator::FilterSettings filter_settings(const Config& config) {
  estimator::FilterSettings settings;
  settings.vehicle = config.vehicle;
  settings.period_s = static_cast<double>(config.realtime.period_ns) * 1e-9;
  settings.paper = config.paper_noise;
  settings.tuning = config.tuning;
  settings.imu_position = config.imu_position;
  settings.roll_gradient = config.roll_gradient;
  settings.pitch_gradient = config.pitch_gradient;
  settings.window_s = config.window_s;
  for (std::size_t i = 0; i < estimator::source_count; ++i) {
    const SignalSettings& signal = config.can.signals[i];
    if (signal.configured) settings.sigma[i] = signal.sigma;
    settings.dead_band[i] = signal.dead_band;
  }
  settings.camera_max_latency_s = config.camera.max_latency_s;
  settings.camera_gate = config.camera_gate;
  return settings;
}

}  // namespace odomd::daemon
