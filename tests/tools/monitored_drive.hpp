// A recorded or simulated drive, run through the filter and its source flags with failing sensors;
// shared by the fault injection tests and the campaign.
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <filesystem>
#include <limits>
#include <optional>
#include <string>
#include <string_view>
#include <type_traits>
#include <variant>
#include <vector>

#include "can_protocol/sources/log_reader.hpp"
#include "daemon/core/camera_pose.hpp"
#include "daemon/core/config.hpp"
#include "daemon/core/pipeline.hpp"
#include "daemon/core/source_watch.hpp"
#include "estimator/filter.hpp"
#include "estimator/integrity/admission.hpp"
#include "estimator/integrity/integrity.hpp"
#include "tools/drive_files/camera_csv.hpp"
#include "tools/replay/virtual_drive.hpp"

namespace odomd::tools {

/// The samples of a drive as the daemon's pipeline would see them, with the ticks that process
/// them.
struct MonitoredDrive {
  struct Event {
    std::int64_t tick_ns = 0;
    std::variant<estimator::Measurement, estimator::CameraPose> sample;
  };
  estimator::Vehicle vehicle;
  estimator::FilterSettings settings;
  std::int64_t period_ns = 5'000'000;
  std::vector<Event> events;
};

inline estimator::Source source_of(const MonitoredDrive::Event& event) {
  const auto* const sample = std::get_if<estimator::Measurement>(&event.sample);
  return sample != nullptr ? sample->source : estimator::Source::camera;
}

/// Without a camera if `camera` is empty.
inline MonitoredDrive load_drive(daemon::Config config, const std::filesystem::path& log_file,
                                 const std::filesystem::path& camera) {
  MonitoredDrive drive;
  drive.vehicle = config.vehicle;
  drive.period_ns = config.realtime.period_ns;
  drive.settings = daemon::filter_settings(config);
  drive.settings.initialise_from_camera = !camera.empty();
  diagnostics::Diagnostics warnings;
  const std::vector<can::Database> databases = daemon::load_databases(config, warnings);
  can::BusNames buses;
  const std::vector<std::string> logs{log_file};
  can::MergedLog log(logs, buses);
  std::vector<can::Frame> frames;
  while (const can::Frame* const frame = log.next()) frames.push_back(*frame);
  can::Decoder decoder(databases, config.can.bindings, config.can.protections, buses.all());

  const std::int64_t first_ns = first_tick_ns(frames.front().time_ns, drive.period_ns);
  const auto tick_of = [&](std::int64_t time_ns) {
    return std::max(first_ns, first_tick_ns(time_ns, drive.period_ns));
  };
  std::array<can::Sample, can::max_samples_per_frame> samples{};
  for (const can::Frame& frame : frames) {
    const can::DecodeResult result = decoder.decode(frame, samples);
    for (std::size_t i = 0; i < result.count; ++i)
      drive.events.push_back(
          {tick_of(frame.time_ns),
           estimator::Measurement{.source = static_cast<estimator::Source>(samples[i].channel),
                                  .time_ns = samples[i].time_ns,
                                  .value = samples[i].value,
                                  .arrival_ns = tick_of(frame.time_ns)}});
  }
  if (!camera.empty())
    for (const auto& pose : read_camera_log(camera).poses)
      drive.events.push_back(
          {tick_of(pose.arrival_ns), daemon::to_centre_of_gravity(pose, config.camera.lever_arm)});
  std::ranges::stable_sort(drive.events, {}, &MonitoredDrive::Event::tick_ns);
  return drive;
}

/// In the order of the values in with_fault().
enum class FaultKind : std::uint8_t { frozen, offset, drift, non_finite, out_of_range, zero };

inline std::string_view name_of(FaultKind kind) {
  constexpr std::array<std::string_view, 6> names{"frozen",     "offset",       "drift",
                                                  "non_finite", "out_of_range", "zero"};
  return names[static_cast<std::size_t>(kind)];
}

struct Fault {
  estimator::Source source = estimator::Source::yaw_rate;
  FaultKind kind = FaultKind::frozen;
  std::int64_t begin_ns = 0;
  double size = 0.0;  ///< offset in the source's unit, or drift per second
};

/// The drive with a failing sensor; a camera's pose freezes, or moves along x.
inline MonitoredDrive with_fault(MonitoredDrive drive, const Fault& fault) {
  using estimator::CameraPose;
  using estimator::Measurement;
  const MonitoredDrive::Event* last = nullptr;
  std::vector<MonitoredDrive::Event> events = drive.events;
  for (auto& event : events) {
    if (source_of(event) != fault.source) continue;
    if (event.tick_ns < fault.begin_ns) {
      last = &event;
      continue;
    }
    const double t = static_cast<double>(event.tick_ns - fault.begin_ns) * 1e-9;
    const auto fail = [&](double& value, double frozen) {
      switch (fault.kind) {
        case FaultKind::frozen:
          value = frozen;
          break;
        case FaultKind::offset:
          value += fault.size;
          break;
        case FaultKind::drift:
          value += fault.size * t;
          break;
        case FaultKind::non_finite:
          value = std::numeric_limits<double>::quiet_NaN();
          break;
        case FaultKind::out_of_range:
          value = 1e6;
          break;
        case FaultKind::zero:
          value = 0.0;
          break;
      }
    };
    if (auto* const sample = std::get_if<Measurement>(&event.sample)) {
      fail(sample->value, last != nullptr ? std::get<Measurement>(last->sample).value : 0.0);
    } else if (auto* const pose = std::get_if<CameraPose>(&event.sample)) {
      const CameraPose frozen = last != nullptr ? std::get<CameraPose>(last->sample) : CameraPose{};
      fail(pose->x, frozen.x);
      if (fault.kind == FaultKind::frozen) {
        pose->y = frozen.y;
        pose->yaw = frozen.yaw;
      }
    }
  }
  drive.events = std::move(events);
  return drive;
}

struct FlagChange {
  std::int64_t tick_ns = 0;
  estimator::Source source = estimator::Source::yaw_rate;
  estimator::SourceFlag flag = estimator::SourceFlag::ok;
};

inline std::vector<FlagChange> monitored(const MonitoredDrive& drive) {
  estimator::Filter filter = make_filter(estimator::Model::full, drive.settings);
  if (!drive.settings.initialise_from_camera) set_initial_pose(filter, {});
  daemon::SourceWatch watch;
  std::array<estimator::SourceFlag, estimator::source_count> flags{};
  std::vector<FlagChange> changes;
  std::size_t next = 0;
  const auto take = [&](const auto& sample, std::int64_t tick_ns) {
    if constexpr (std::is_same_v<std::decay_t<decltype(sample)>, estimator::Measurement>) {
      const auto source = static_cast<std::size_t>(sample.source);
      if (const auto refused = estimator::refusal(sample)) {
        watch.refused(source, *refused, tick_ns);
      } else {
        watch.usable(source);
      }
    } else if (estimator::is_usable(sample)) {
      watch.usable_pose();
    } else {
      watch.unusable_pose();
    }
    add(filter, sample);
  };
  for (std::int64_t tick_ns = drive.events.front().tick_ns; next < drive.events.size();
       tick_ns += drive.period_ns) {
    for (; next < drive.events.size() && drive.events[next].tick_ns <= tick_ns; ++next)
      std::visit([&](const auto& sample) { take(sample, tick_ns); }, drive.events[next].sample);
    step(filter, tick_ns);
    watch.settle(tick_ns);
    for (std::size_t i = 0; i < flags.size(); ++i) {
      const auto source = static_cast<estimator::Source>(i);
      const auto refused = watch.flag(i);
      const auto now = refused != estimator::SourceFlag::ok ? refused : flag(filter, source);
      if (now == flags[i]) continue;
      flags[i] = now;
      changes.push_back({tick_ns, source, now});
    }
  }
  return changes;
}

/// A fault, and the smallest error that other sources can detect [source's unit].
struct FaultCase {
  Fault fault;
  double visible = 0.0;
};

/// All faults to try on a drive, for the sources that it has, with sizes that suit its car.
inline std::vector<FaultCase> fault_cases(const MonitoredDrive& drive) {
  using enum estimator::Source;
  using enum FaultKind;
  const bool small = drive.vehicle.wheelbase() < 1.0;
  const double turn = small ? 0.7 : 0.25;    // [rad/s]
  const double steer = small ? 0.12 : 0.04;  // [rad]
  const double accel = 3.0;                  // [m/s²]
  const double speed = small ? 0.5 : 4.0;    // [m/s]
  const double way = small ? 0.25 : 3.0;     // [m]
  const std::vector<FaultCase> all{
      {{yaw_rate, frozen}, turn},
      {{.source = yaw_rate, .kind = offset, .size = 1.5 * turn}, turn},
      {{.source = yaw_rate, .kind = drift, .size = turn}, 1.5 * turn},
      {{yaw_rate, non_finite}, 0.0},
      {{yaw_rate, out_of_range}, 0.0},
      {{steering, frozen}, steer},
      {{steering, non_finite}, 0.0},
      {{accel_x, frozen}, accel},
      {{.source = accel_x, .kind = offset, .size = 1.5 * accel}, accel},
      {{.source = accel_x, .kind = drift, .size = accel}, 1.5 * accel},
      {{accel_x, out_of_range}, 0.0},
      {{accel_y, frozen}, accel},
      {{.source = accel_y, .kind = offset, .size = 1.5 * accel}, accel},
      {{.source = accel_y, .kind = drift, .size = accel}, 1.5 * accel},
      {{accel_y, non_finite}, 0.0},
      {{wheel_front_right, frozen}, speed},
      {{wheel_front_right, zero}, speed},
      {{wheel_rear_left, frozen}, speed},
      {{wheel_rear_left, zero}, speed},
      {{.source = wheel_rear_left, .kind = offset, .size = 1.5 * speed}, speed},
      {{.source = wheel_rear_left, .kind = drift, .size = speed}, 1.5 * speed},
      {{wheel_rear_left, out_of_range}, 0.0},
      {{camera, frozen}, way},
      {{camera, non_finite}, 0.0},
  };
  std::vector<FaultCase> here;
  for (const FaultCase& one : all)
    if (std::ranges::any_of(
            drive.events, [&](const auto& event) { return source_of(event) == one.fault.source; }))
      here.push_back(one);
  return here;
}

/// Start of the first 0.3 s in which the source's error exceeds `visible` all the time while the
/// car moves: the fault is observable then. At once if `visible` is 0.
inline std::optional<std::int64_t> shown_at(const MonitoredDrive& drive,
                                            const MonitoredDrive& failed, const FaultCase& one) {
  constexpr std::int64_t long_enough_ns = 300'000'000;
  constexpr double slow = 0.3;  // [m/s]
  constexpr double grip = 5.0;  // [m/s²]: beyond it, steering does not determine the yaw rate
  double speed = 0.0;
  double side = 0.0;
  std::optional<std::int64_t> since;
  for (std::size_t i = 0; i < drive.events.size(); ++i) {
    const auto* const sample = std::get_if<estimator::Measurement>(&drive.events[i].sample);
    if (sample != nullptr && sample->source >= estimator::Source::wheel_front_left &&
        sample->source <= estimator::Source::motor)
      speed = std::abs(sample->value);
    if (sample != nullptr && sample->source == estimator::Source::yaw_rate)
      side = std::abs(speed * sample->value);
    if (drive.events[i].tick_ns < one.fault.begin_ns ||
        source_of(drive.events[i]) != one.fault.source)
      continue;
    if (one.visible == 0.0) return drive.events[i].tick_ns;
    double off = 0.0;
    if (sample != nullptr) {
      off =
          std::abs(std::get<estimator::Measurement>(failed.events[i].sample).value - sample->value);
    } else {
      const auto& pose = std::get<estimator::CameraPose>(drive.events[i].sample);
      const auto& wrong = std::get<estimator::CameraPose>(failed.events[i].sample);
      off = std::hypot(pose.x - wrong.x, pose.y - wrong.y);
    }
    const bool slides = one.fault.source == estimator::Source::steering && side > grip;
    if (!(off > one.visible) || speed < slow || slides) {
      since.reset();
    } else if (!since) {
      since = drive.events[i].tick_ns;
    } else if (drive.events[i].tick_ns - *since >= long_enough_ns) {
      return since;
    }
  }
  return std::nullopt;
}

}  // namespace odomd::tools
