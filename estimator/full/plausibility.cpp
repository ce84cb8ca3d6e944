#include "estimator/full/plausibility.hpp"

#include <algorithm>
#include <cmath>

#include "estimator/time.hpp"

namespace odomd::estimator::full {
namespace {

// For so long a reading says something of the next; no car changes its motion faster for longer.
constexpr double longest_pause_s = 1.5;
constexpr double longest_change_s = 0.1;

constexpr int fewest_rejected = 3;
constexpr int most_counted = 3;

/// |z_2 - z_1| ≤ at_once + rate Δt: kerbs, collisions, spinning wheels and those of one axle in a
/// tight turn are within.
struct Change {
  double at_once;
  double rate;  ///< per second
};

constexpr Change largest_change(Source source) noexcept {
  switch (source) {
    case Source::yaw_rate:
      return {0.5, 60.0};
    case Source::accel_x:
    case Source::accel_y:
      return {10.0, 500.0};
    default:  // wheels
      return {2.0, 30.0};
  }
}

bool agree(const Reading& before, const Sample& sample) noexcept {
  const double elapsed_s = seconds_between(before.time_ns, sample.time_ns);
  const Change change = largest_change(sample.source);
  return before.agreeing > 0 && elapsed_s <= longest_pause_s &&
         std::abs(sample.value[0] - before.value) <=
             change.at_once + change.rate * std::min(elapsed_s, longest_change_s);
}

}  // namespace

int vouchers(const State& state, const Sample& sample) noexcept {
  const auto of = [&](std::size_t source) {
    const Reading& before = state.heard[source];
    return agree(before, sample) ? before.agreeing : 0;
  };
  if (!is_wheel(sample.source)) {
    return of(index_of(sample.source));
  }
  int most = 0;
  for (std::size_t i = index_of(Source::wheel_front_left); i <= index_of(Source::motor); ++i) {
    most = std::max(most, of(i));
  }
  return most;
}

std::int64_t vouching_since_ns(const State& state, const Sample& sample) noexcept {
  std::int64_t since_ns = sample.time_ns;
  for (std::size_t i = index_of(Source::wheel_front_left); i <= index_of(Source::motor); ++i) {
    if (agree(state.heard[i], sample)) {
      since_ns = std::min(since_ns, state.heard[i].time_ns);
    }
  }
  return since_ns;
}

void note_heard(State& state, const Sample& sample) noexcept {
  const int agreeing = std::min(vouchers(state, sample) + 1, most_counted);
  state.heard[index_of(sample.source)] = {agreeing, sample.time_ns, sample.value[0]};
}

void count_rejected(State& state, const Sample& sample) noexcept {
  const std::size_t index = index_of(sample.source);
  Rejection& rejection = state.rejected[index];
  if (rejection.count == 0 || !agree(state.heard[index], sample)) {
    rejection = {0, sample.time_ns, state.mean[at::v_x]};
  }
  rejection.count = std::min(rejection.count + 1, fewest_rejected);
}

bool insists(const State& state, const Sample& sample, std::int64_t fused_ns,
             double patience_s) noexcept {
  const Rejection& rejection = state.rejected[index_of(sample.source)];
  return rejection.count >= fewest_rejected &&
         seconds_between(std::max(rejection.since_ns, fused_ns), sample.time_ns) >= patience_s;
}

}  // namespace odomd::estimator::full
