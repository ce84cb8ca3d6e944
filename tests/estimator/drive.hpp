// Passes simulated samples to a filter, a tick at a time.
#pragma once

#include <cstdint>
#include <optional>

#include "estimator/filter.hpp"

namespace odomd::estimator::testing {

inline constexpr std::int64_t millisecond = 1'000'000;
inline constexpr std::int64_t period_ns = 5 * millisecond;

/// The samples of one tick; missing ones are not sent.
struct Samples {
  std::optional<double> speed = std::nullopt;  ///< wheel_rear
  std::optional<double> steering = std::nullopt;
  std::optional<double> yaw_rate = std::nullopt;
  std::optional<double> accel_x = std::nullopt;
};

/// A filter and the clock of its ticks.
struct Drive {
  Filter filter;
  std::int64_t now_ns = 1'000'000'000;
  Estimate last{};

  /// Drives one tick; the samples have its time.
  Estimate tick(const Samples& samples) {
    now_ns += period_ns;
    const auto send = [&](Source source, const std::optional<double>& value) {
      if (value) {
        add(filter, Measurement{source, now_ns, *value, 0.0});
      }
    };
    send(Source::wheel_rear, samples.speed);
    send(Source::steering, samples.steering);
    send(Source::yaw_rate, samples.yaw_rate);
    send(Source::accel_x, samples.accel_x);
    last = step(filter, now_ns);
    return last;
  }

  Estimate ticks(int count, const Samples& samples) {
    for (int i = 0; i < count; ++i) {
      tick(samples);
    }
    return last;
  }
};

inline Drive start(Model model, FilterSettings settings = {},
                   std::optional<Pose2> initial = Pose2{}) {
  Drive drive{make_filter(model, settings)};
  if (initial) {
    set_initial_pose(drive.filter, *initial);
  }
  return drive;
}

}  // namespace odomd::estimator::testing
