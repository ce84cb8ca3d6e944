// docs/model.md, "Noise from the data".
#include "estimator/ekf/judge.hpp"

#include <algorithm>
#include <cmath>

#include "estimator/common/symmetric3.hpp"

namespace odomd::estimator::full {
namespace {

// Variance of z_k - 2 z_k-1 + z_k-2 for white noise of variance 1: 1² + 2² + 1².
constexpr double bend_variance = 1.0 + squared(2.0) + 1.0;
constexpr int least_samples_to_use = integrity::least_samples;  // with fewer the mean is not used
constexpr int least_samples_to_bound = 10;  // with fewer the stated variance bounds a sample
// From 0 the mean could not grow again.
constexpr double smallest_mean = 1e-4;
// A still sensor is never taken as noisier than stated.
constexpr double as_stated = 1.0;

/// The sigma to use, relative to the stated one, from a relative mean square.
double bounded(const Tuning& tuning, double mean, bool wheels_still) noexcept {
  const double range = tuning.noise_range;
  const double least = wheels_still ? 1.0 / (range * range) : 1.0 / range;
  const double most = wheels_still ? as_stated : range;
  return std::sqrt(std::clamp(mean, least, most));
}

// Bounds of one sample's effect on a scale.
constexpr double largest_excess = 4.0;
constexpr double largest_share = 0.1;

void adapt(double& noise_scale, double ratio, double share, double least, double most) noexcept {
  const double change = std::min(share, largest_share) * std::min(ratio - 1.0, largest_excess);
  noise_scale = std::clamp(noise_scale * std::exp(change), least, most);
}

}  // namespace

void measure_noise(const Tuning& tuning, State& state, Sample& sample) noexcept {
  NoiseLevel& level = state.noise[index_of(sample.source)];
  if (level.wheels_still != state.standstill.wheels_still) {
    level.wheels_still = state.standstill.wheels_still;
    level.run = 0;
  }
  const double now = sample.value[0] / sample.sigma[0];
  auto& [mean, samples] = level.wheels_still ? level.still : level.moving;
  if (level.run == 2) {
    const double bend = now - 2.0 * level.last[0] + level.last[1];
    samples = std::min(samples + 1, tuning.noise_samples);
    const double most =
        squared(most_sigmas) * (samples < least_samples_to_bound ? as_stated : mean);
    mean += (std::min(bend * bend / bend_variance, most) - mean) / samples;
    mean = std::max(mean, smallest_mean);
  }
  level.last = {now, level.last[0]};
  level.run = std::min(level.run + 1, 2);
  if (samples >= least_samples_to_use) {
    sample.sigma[0] *= bounded(tuning, mean, level.wheels_still);
  }
}

SourceNoise noise_of(const Tuning& tuning, const State& state, Source source,
                     double stated) noexcept {
  SourceNoise noise{.stated = stated};
  if (is_inertial(source)) {
    const NoiseLevel& level = state.noise[index_of(source)];
    if (level.still.samples >= least_samples_to_use) {
      noise.at_rest = stated * bounded(tuning, level.still.mean, true);
    }
    if (level.moving.samples >= least_samples_to_use) {
      noise.moving = stated * bounded(tuning, level.moving.mean, false);
    }
  } else if (is_wheel(source) && state.reading(source).consistent > 0) {
    noise.speed_share = tuning.wheel_radius * std::sqrt(state.reading(source).noise_scale);
  }
  return noise;
}

void adapt_noise_scales(const Tuning& tuning, State& state, const Sample& sample,
                        const Prediction& z, const Innovation& nu) noexcept {
  if (state.standstill.standing) {
    return;
  }
  const double interval_s = state.reading(sample.source).interval_s;
  const double ratio = nu.value * nu.value / nu.variance_of_noise;
  if (is_wheel(sample.source)) {
    const double state_share = 1.0 - z.variance / nu.variance_of_noise;
    const double wheel_share = z.relative / nu.variance_of_noise;
    adapt(state.drive_noise_scale, ratio, state_share * interval_s / tuning.wheel_noise_scale_s,
          1.0 / tuning.drive_noise_scale_range, tuning.drive_noise_scale_range);
    adapt(state.reading(sample.source).noise_scale, ratio,
          wheel_share * interval_s / tuning.wheel_noise_scale_s,
          1.0 / tuning.wheel_noise_scale_range, tuning.wheel_noise_scale_range);
  } else if (sample.source == Source::yaw_rate) {
    adapt(state.turn_noise_scale, ratio, interval_s / tuning.turn_noise_scale_s,
          1.0 / tuning.turn_noise_scale_range, 1.0);
  }
}

void adapt_way_noise_scale(const Tuning& tuning, State& state, double squared_ratio,
                           double interval_s) noexcept {
  adapt(state.way_noise_scale, third * squared_ratio, interval_s / tuning.way_noise_scale_s, 1.0,
        tuning.way_noise_scale_range);
}

}  // namespace odomd::estimator::full
