// docs/model.md, "Integrity".
#include "estimator/integrity/hypotheses.hpp"

#include <array>
#include <cmath>

#include "estimator/common/time.hpp"

namespace odomd::estimator::integrity {
namespace {

constexpr Sources inertial = only(Source::yaw_rate) | only(Source::accel_x) | only(Source::accel_y);

/// What may fail together, and how unlikely that is: -2 log of its probability, over that of a
/// single source.
struct Hypothesis {
  Sources sources;
  double unlikely;
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

// A source that repeats itself to the bit, or has jumped as no car does, is so much likelier at
// fault.
constexpr double odd = 20.0;
constexpr double odd_for_s = 1.0;

/// Whether all of them that are heard repeat themselves, or have jumped.
bool is_odd(const Heard& heard, Sources sources, const WithoutWheels& without) noexcept {
  constexpr double slack = 0.02;  // [m/s]: slower is a wheel that rests
  for (std::size_t i = 0; i < source_count; ++i) {
    const Witness& witness = heard.sources[i];
    if (!contains(sources, i) || !witness.alive(heard.now_ns)) {
      continue;
    }
    const bool quick = is_wheel(static_cast<Source>(i)) &&
                       std::abs(witness.rate(Over::short_time)) > 3.0 * gravity;
    const bool jumped = quick || (witness.jumped_ns != 0 &&
                                  seconds_between(witness.jumped_ns, heard.now_ns) <= odd_for_s);
    // A wheel that is read in steps repeats itself as long as the car goes evenly, or stands.
    const bool rests = std::abs(witness.value) < slack;
    const bool evenly =
        is_wheel(static_cast<Source>(i)) &&
        (rests || std::abs(heard.speed() - heard.speed(Over::long_time)) < 3.0 * witness.sigma) &&
        std::abs(witness.mean() - without.speed) < (rests ? 0.5 : 3.0) * without.sigma;
    const bool repeats = witness.repeats() && !evenly;
    if (!repeats && !jumped) {
      return false;
    }
  }
  return true;
}

}  // namespace

Sources suspects(const Heard& heard, const Consensus& all, const Solution& base, Sources out,
                 const WithoutWheels& without_wheels) noexcept {
  struct Candidate {
    Sources sources = 0;
    double score = 0.0;
  };
  Sources told = 0;
  for (const Row& row : all) {
    told |= row.sources;
  }
  const bool slides = heard.slides(heard.now_ns, 4.0 * mean_s.back());
  std::array<Candidate, hypotheses.size()> tried{};
  Candidate best{.score = base.misfit - gate};
  for (std::size_t i = 0; i < hypotheses.size(); ++i) {
    const Sources sources = hypotheses[i].sources & told & ~out;
    const bool is_strange = is_odd(heard, sources, without_wheels);
    // A car that spins contradicts all of an IMU that is sound.
    if (sources == 0 || (sources == inertial && !is_strange && slides)) {
      continue;
    }
    tried[i] = {sources, all.without(out | sources).misfit + hypotheses[i].unlikely -
                             (is_strange ? odd : 0.0)};
    if (tried[i].score < best.score) {
      best = tried[i];
    }
  }
  for (const Candidate& other : tried) {
    if (other.sources != 0 && (other.sources & best.sources) == 0 &&
        other.score < best.score + margin) {
      return 0;  // one word against another
    }
  }
  return best.sources;
}

}  // namespace odomd::estimator::integrity
