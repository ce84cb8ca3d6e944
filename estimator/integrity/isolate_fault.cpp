// docs/model.md, "Integrity".
#include "estimator/integrity/equations.hpp"

#include <array>
#include <cmath>

#include "estimator/common/symmetric3.hpp"

namespace odomd::estimator::integrity {
namespace {

constexpr Sources inertial = set_of(is_inertial);

/// A set of sources that may fail together, and its score: first the penalty, -2 log of its
/// probability relative to a single source's; later the misfit of the observations is added.
struct Hypothesis {
  Sources sources = 0;
  double score = 0.0;
};
constexpr double pair = 8.0;
constexpr double group = 14.0;
constexpr std::array groups{Hypothesis{front_wheels, pair}, Hypothesis{rear_wheels, pair},
                            Hypothesis{wheels, group}, Hypothesis{inertial, group},
                            Hypothesis{turn_models, group}};

// Sources that contradict the others in a slide, without a fault.
constexpr Sources witnesses = inertial | only(Source::camera);

// Penalty in a slide: a spin contradicts even an IMU without a fault; outer wheels keep rolling.
constexpr double slide_penalty = 10.0;

// Bonus for a source whose bits repeat or a wheel that slips: it is more likely to be at fault.
constexpr double anomaly_bonus = 20.0;

/// Whether every live source of this set repeats its bits, or slips.
bool is_anomalous(const Observations& observed, Sources sources, const Solution& without) noexcept {
  for (const Source source : all_sources) {
    const SourceHistory& history = observed.history(source);
    if (!contains(sources, source) || !history.alive(observed.now_ns)) {
      continue;
    }
    const bool wheel = is_wheel(source);
    // A quantised wheel speed repeats while the car goes at a constant speed, or stands.
    const bool stands = std::abs(history.value) < slowest_turning;
    const bool constant = wheel &&
                          (stands || std::abs(observed.speed() - observed.speed(Over::long_time)) <
                                         most_sigmas * history.sigma) &&
                          std::abs(history.mean() - without.motion[of::speed]) <
                              (stands ? 0.5 : most_sigmas) * without.sigma[of::speed];
    const bool slips = wheel && observed.slips(source);
    if (!slips && (constant || !observed.repeats(source))) {
      return false;
    }
  }
  return true;
}

}  // namespace

Sources isolate_fault(const Observations& observed, const Consensus& all, const Solution& base,
                      const Solution& without_wheels) noexcept {
  const Sources out = observed.distrusted;
  const Sources suspects = all.present() & ~out;
  const Sources speeds = suspects & (wheels | only(Source::camera));
  const bool slides = observed.slides(observed.now_ns, Over::long_time);
  const bool witnessed = observed.slid() && observed.seen();
  const Side outside = observed.speed() * observed.yaw_rate() > 0.0 ? Side::right : Side::left;
  const Sources outer_wheels = set_of([&](Source wheel) { return info_of(wheel).side == outside; });
  std::array<Hypothesis, source_count + groups.size()> tried{};
  Hypothesis best{.score = base.misfit - gate};
  for (std::size_t i = 0; i < tried.size(); ++i) {
    const Hypothesis hypothesis =
        i < source_count ? Hypothesis{only(all_sources[i]), 0.0} : groups[i - source_count];
    const Sources sources = hypothesis.sources & suspects;
    if (sources == 0 || (witnessed && (sources & ~witnesses) == 0) ||
        (!observed.seen() && hypothesis.sources == turn_models)) {
      continue;
    }
    // The inner wheels carry less and slip first.
    const bool outer = slides && (sources & outer_wheels) != 0 && (sources & ~outer_wheels) == 0;
    // Without its last speed source the car has only the integrated speed.
    const bool only_speed = (sources & speeds) != 0 && (speeds & ~sources) == 0;
    tried[i] = {
        sources,
        all.without(out | sources).misfit + (only_speed ? group : hypothesis.score) +
            (outer || (slides && (out & wheels) != 0 && (sources & ~inertial) == 0) ? slide_penalty
                                                                                    : 0.0) -
            (is_anomalous(observed, sources, without_wheels) ? anomaly_bonus : 0.0)};
    if (tried[i].score < best.score) {
      best = tried[i];
    }
  }
  for (const Hypothesis& other : tried) {
    if (other.sources != 0 && (other.sources & best.sources) == 0 &&
        other.score < best.score + margin) {
      return 0;  // ambiguous
    }
  }
  return best.sources;
}

}  // namespace odomd::estimator::integrity
