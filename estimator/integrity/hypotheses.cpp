// docs/model.md, "Integrity".
#include "estimator/integrity/hypotheses.hpp"

#include <array>
#include <cmath>

#include "estimator/common/time.hpp"

namespace odomd::estimator::integrity {
namespace {

constexpr Sources inertial = only(Source::yaw_rate) | only(Source::accel_x) | only(Source::accel_y);

/// What may fail together, and how penalty that is: -2 log of its probability, over that of a
/// single source.
struct Hypothesis {
  Sources sources;
  double penalty;
};
constexpr double pair = 8.0;
constexpr double group = 14.0;
constexpr std::array hypotheses{
    Hypothesis{only(Source::yaw_rate), 0.0},
    Hypothesis{only(Source::accel_x), 0.0},
    Hypothesis{only(Source::accel_y), 0.0},
    Hypothesis{only(Source::wheel_front_left), 0.0},
    Hypothesis{only(Source::wheel_front_right), 0.0},
    Hypothesis{only(Source::wheel_rear_left), 0.0},
    Hypothesis{only(Source::wheel_rear_right), 0.0},
    Hypothesis{only(Source::wheel_rear), 0.0},
    Hypothesis{only(Source::motor), 0.0},
    Hypothesis{only(Source::steering), 0.0},
    Hypothesis{only(Source::camera), 0.0},
    Hypothesis{front_wheels, pair},
    Hypothesis{rear_wheels, pair},
    Hypothesis{wheels, group},
    Hypothesis{inertial, group},
};

// A car that spins contradicts an IMU that has no fault, and outer wheels roll in a slide.
constexpr double slide_penalty = 10.0;

// A source whose bits repeat, or that jumped, is so much more likely to be at fault.
constexpr double anomaly_bonus = 20.0;
constexpr double jump_memory_s = 1.0;

/// Whether all of these sources that are alive repeat their bits, or have jumped.
bool is_anomalous(const Observations& observed, Sources sources,
                  const WithoutWheels& without) noexcept {
  constexpr double standing_speed = 0.02;  // [m/s]
  for (std::size_t i = 0; i < source_count; ++i) {
    const SourceHistory& history = observed.sources[i];
    if (!contains(sources, i) || !history.alive(observed.now_ns)) {
      continue;
    }
    const bool wheel = is_wheel(static_cast<Source>(i));
    const bool jumped = (wheel && std::abs(history.rate(Over::short_time)) > 3.0 * gravity) ||
                        (history.jumped_ns != 0 &&
                         seconds_between(history.jumped_ns, observed.now_ns) <= jump_memory_s);
    // A quantised wheel speed repeats while the car goes at a constant speed, or stands.
    const bool stands = std::abs(history.value) < standing_speed;
    const bool constant =
        wheel &&
        (stands ||
         std::abs(observed.speed() - observed.speed(Over::long_time)) < 3.0 * history.sigma) &&
        std::abs(history.mean() - without.speed) < (stands ? 0.5 : 3.0) * without.sigma;
    if (!jumped && (constant || !observed.repeats(static_cast<Source>(i)))) {
      return false;
    }
  }
  return true;
}

}  // namespace

Sources isolate_fault(const Observations& observed, const Consensus& all, const Solution& base,
                      Sources out, const WithoutWheels& without_wheels) noexcept {
  struct Candidate {
    Sources sources = 0;
    double score = 0.0;
  };
  Sources present = 0;
  for (const Row& row : all) {
    present |= row.sources;
  }
  const Sources speeds = present & ~out & (wheels | only(Source::camera));
  const bool slides = observed.slides(observed.now_ns, 4.0 * mean_s.back());
  const bool spins = slides && (out & wheels) != 0;
  const Sources outer_wheels =
      observed.speed() * observed.yaw_rate() > 0.0
          ? only(Source::wheel_front_right) | only(Source::wheel_rear_right)
          : only(Source::wheel_front_left) | only(Source::wheel_rear_left);
  std::array<Candidate, hypotheses.size()> tried{};
  Candidate best{.score = base.misfit - gate};
  for (std::size_t i = 0; i < hypotheses.size(); ++i) {
    const Sources sources = hypotheses[i].sources & present & ~out;
    const bool anomalous = is_anomalous(observed, sources, without_wheels);
    if (sources == 0) {
      continue;
    }
    // The inner wheels carry less and slip first.
    const bool outer = slides && (sources & outer_wheels) != 0 && (sources & ~outer_wheels) == 0;
    // Without its last speed the car has only what it integrates.
    const bool only_speed = (sources & speeds) != 0 && (speeds & ~sources) == 0;
    tried[i] = {sources,
                all.without(out | sources).misfit + (only_speed ? group : hypotheses[i].penalty) +
                    (outer || (spins && (sources & ~inertial) == 0) ? slide_penalty : 0.0) -
                    (anomalous ? anomaly_bonus : 0.0)};
    if (tried[i].score < best.score) {
      best = tried[i];
    }
  }
  for (const Candidate& other : tried) {
    if (other.sources != 0 && (other.sources & best.sources) == 0 &&
        other.score < best.score + margin) {
      return 0;  // ambiguous
    }
  }
  return best.sources;
}

}  // namespace odomd::estimator::integrity
