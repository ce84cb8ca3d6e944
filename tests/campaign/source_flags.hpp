// When the source flags of a run change, and when a fault becomes observable.
#pragma once

#include <array>
#include <cmath>
#include <optional>
#include <span>
#include <string_view>
#include <vector>

#include "tests/campaign/faulty_drive.hpp"
#include "tools/fault/car_signals.hpp"
#include "tools/replay/virtual_drive.hpp"

namespace odomd::campaign {

using estimator::Source;

struct FlagChange {
  std::int64_t tick_ns = 0;
  Source source = Source::yaw_rate;
  std::string_view flag;
};

/// The changes in a run whose first tick has the number `first`; `before` is the tick before it.
inline std::vector<FlagChange> flag_changes(const Drive& drive, std::span<const Tick> run,
                                            std::size_t first = 0, Tick before = {}) {
  std::vector<FlagChange> changes;
  for (const Tick& tick : run) {
    for (std::size_t i = 0; i < tick.flags.size(); ++i)
      if (tick.flags[i] != before.flags[i])
        changes.push_back({drive.tick_ns(first), static_cast<Source>(i),
                           estimator::source_flag_names[tick.flags[i]]});
    before = tick;
    ++first;
  }
  return changes;
}

/// A fault, and the smallest error that other sources can detect [source's unit].
struct FaultCase {
  fault::Fault fault;
  double visible = 0.0;
};

/// The faults to try on a simulated drive from `begin_s` on, with sizes that suit its car.
inline std::vector<FaultCase> fault_cases(const Drive& drive, double begin_s) {
  const bool small = drive.config.vehicle.wheelbase() < 1.0;
  const double turn = small ? 0.7 : 0.25;    // [rad/s]
  const double steer = small ? 0.12 : 0.04;  // [rad]
  const double accel = 3.0;                  // [m/s²]
  const double speed = small ? 0.5 : 4.0;    // [m/s]
  const double way = small ? 0.25 : 3.0;     // [m]
  struct Row {
    const char* kind;
    double visible;
    double size = 0.0;
  };
  std::vector<FaultCase> cases;
  for (const auto& [kind, visible, size] : {Row{"gyro.frozen", turn},
                                            {"gyro.biased", turn, 1.5 * turn},
                                            {"gyro.ramped", 1.5 * turn, turn},
                                            {"steering.frozen", steer},
                                            {"accel_x.frozen", accel},
                                            {"accel_x.biased", accel, 1.5 * accel},
                                            {"accel_x.ramped", 1.5 * accel, accel},
                                            {"accel_y.frozen", accel},
                                            {"accel_y.biased", accel, 1.5 * accel},
                                            {"accel_y.ramped", 1.5 * accel, accel},
                                            {"wheel_front_right.frozen", speed},
                                            {"wheel_front_right.zero", speed},
                                            {"wheel_rear_left.frozen", speed},
                                            {"wheel_rear_left.zero", speed},
                                            {"wheel_rear_left.biased", speed, 1.5 * speed},
                                            {"wheel_rear_left.ramped", 1.5 * speed, speed},
                                            {"camera.frozen", way}})
    cases.push_back(
        {{.kind = fault::parse_kind(kind), .begin_s = begin_s, .magnitude = size}, visible});
  return cases;
}

/// When the fault becomes observable: the first tick of the first 0.3 s during which the car moves
/// and the source's error exceeds `visible` all the time.
inline std::optional<std::int64_t> shown_at(const Drive& drive, const FaultCase& one) {
  constexpr std::int64_t long_enough_ns = 300'000'000;
  constexpr double slow = 0.3;  // [m/s]
  constexpr double grip = 5.0;  // [m/s²]: beyond it, steering does not determine the yaw rate
  const fault::Sources sources = fault::sources_of(one.fault.kind);
  double speed = 0.0, side = 0.0;
  std::optional<std::int64_t> since;
  const auto has_shown = [&](std::int64_t t_ns, double error) {
    const bool slides = fault::contains(sources, Source::steering) && side > grip;
    if (error <= one.visible || speed < slow || slides)
      since.reset();
    else if (!since)
      since = tools::first_tick_ns(t_ns, drive.config.realtime.period_ns);
    return since && t_ns - *since >= long_enough_ns;
  };
  const fault::CarSignals signals(drive.config.can, drive.databases, drive.buses);
  const Sent failed = sent(drive, {&one.fault, 1});
  std::array<fault::Reading, can::max_samples_per_frame> right{}, wrong{};
  std::size_t pose = 0;
  for (std::size_t i = 0; i < drive.frames.size(); ++i) {
    const can::Frame& frame = drive.frames[i];
    for (; pose < drive.cameras.size() && drive.cameras[pose].arrival_ns <= frame.time_ns; ++pose) {
      const auto &a = drive.cameras[pose], &b = failed.cameras[pose];
      if (fault::contains(sources, Source::camera) &&
          has_shown(a.arrival_ns, std::hypot(a.x - b.x, a.y - b.y)))
        return since;
    }
    const auto message = signals.message_of(frame);
    if (!message) continue;
    const std::size_t count = signals.read(*message, frame, right);
    signals.read(*message, failed.frames[i], wrong);
    for (std::size_t k = 0; k < count; ++k) {
      const auto& [binding, source, value] = right[k];
      if (is_wheel(source)) speed = std::abs(value);
      if (source == Source::yaw_rate) side = std::abs(speed * value);
      if (fault::contains(sources, source) &&
          has_shown(frame.time_ns, std::abs(wrong[k].value - value)))
        return since;
    }
  }
  return std::nullopt;
}

}  // namespace odomd::campaign
