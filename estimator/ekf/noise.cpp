// docs/model.md, "Noise from the data".
#include "estimator/ekf/noise.hpp"

#include <algorithm>
#include <cmath>

namespace odomd::estimator::full {
namespace {

// How many samples the noise is estimated from, and by how much one of them may be above it.
constexpr int noise_memory = 300;
constexpr double largest_step = 9.0;

// One surprise counts as so many at most, and moves a ratio by no more than this of itself.
constexpr double largest_surprise = 4.0;
constexpr double largest_share = 0.1;

struct Bounds {
  double least;
  double most;
};

void follow(double& unrest, double surprise, double share, Bounds bounds) noexcept {
  const double change = std::min(share, largest_share) * std::min(surprise - 1.0, largest_surprise);
  unrest = std::clamp(unrest * std::exp(change), bounds.least, bounds.most);
}

}  // namespace

void measure_noise(State& state, Sample& sample) noexcept {
  NoiseLevel& level = state.noise[index_of(sample.source)];
  if (level.resting != state.rest.resting) {
    level.resting = state.rest.resting;
    level.run = 0;
  }
  const double now = sample.value[0] / sample.sigma[0];
  double& mean = level.resting ? level.at_rest : level.moving;
  int& samples = level.resting ? level.rest_samples : level.moving_samples;
  if (level.run == 2) {
    const double bend = now - 2.0 * level.last[0] + level.last[1];
    samples = std::min(samples + 1, noise_memory);
    const double most = largest_step * (samples < 10 ? 1.0 : mean);
    mean += (std::min(bend * bend / 6.0, most) - mean) / samples;
    mean = std::max(mean, 1e-4);
  }
  level.last = {now, level.last[0]};
  level.run = std::min(level.run + 1, 2);
  if (samples < 5) {
    return;
  }
  const bool gyro = sample.source == Source::yaw_rate;
  const double ratio =
      level.resting ? std::clamp(mean, 0.01, 1.0) : std::clamp(mean, 0.1, gyro ? 1.0 : 9.0);
  sample.sigma[0] *= std::sqrt(ratio);
}

void follow_unrest(const Tuning& tuning, State& state, const Sample& sample,
                   const Innovation& nu) noexcept {
  if (state.rest.standing) {
    return;
  }
  const double interval_s = state.heard[index_of(sample.source)].interval_s;
  const double surprise = nu.value * nu.value / nu.variance_of_noise;
  const double of_noise = nu.sample_variance / nu.variance_of_noise;
  if (is_wheel(sample.source)) {
    follow(state.drive_unrest, surprise, (1.0 - of_noise) * interval_s / tuning.drive_unrest_s,
           {1.0 / tuning.drive_unrest_range, tuning.drive_unrest_range});
    follow(state.wheel_unrest[index_of(sample.source)], surprise,
           of_noise * interval_s / tuning.wheel_unrest_s,
           {1.0 / tuning.wheel_unrest_range, tuning.wheel_unrest_range});
  } else if (sample.source == Source::yaw_rate) {
    follow(state.turn_unrest, surprise, interval_s / tuning.turn_unrest_s,
           {1.0 / tuning.turn_unrest_range, 1.0});
  }
}

void follow_way_unrest(const Tuning& tuning, State& state, double squared_ratio,
                       double interval_s) noexcept {
  follow(state.way_unrest, squared_ratio / 3.0, interval_s / tuning.way_unrest_s,
         {1.0, tuning.way_unrest_range});
}

}  // namespace odomd::estimator::full
