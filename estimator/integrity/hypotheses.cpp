// docs/model.md, "Integrity".
#include "estimator/integrity/hypotheses.hpp"

#include <array>

#include "estimator/common/time.hpp"

namespace odomd::estimator::integrity {
namespace {

/// A set of sources that may fail together, and its score: first the penalty, -2 log of its
/// probability relative to that of a single source, then with what the observations say.
struct Hypothesis {
  Sources sources = 0;
  double score = 0.0;
};
constexpr double pair = 8.0;
constexpr double group = 14.0;
constexpr std::array groups{Hypothesis{front_wheels, pair}, Hypothesis{rear_wheels, pair},
                            Hypothesis{wheels, group}};

// A source whose bits repeat, or that jumped, is so much more likely to be at fault.
constexpr double anomaly_bonus = 20.0;
constexpr double jump_memory_s = 1.0;

/// Whether all of these sources that are alive repeat their bits, or have jumped.
bool is_anomalous(const Observations& observed, Sources sources) noexcept {
  for (std::size_t i = 0; i < source_count; ++i) {
    const SourceHistory& history = observed.sources[i];
    const bool jumped = history.jumped_ns != 0 &&
                        seconds_between(history.jumped_ns, observed.now_ns) <= jump_memory_s;
    if (contains(sources, i) && history.alive(observed.now_ns) && !jumped &&
        !observed.repeats(static_cast<Source>(i))) {
      return false;
    }
  }
  return true;
}

}  // namespace

Sources isolate_fault(const Observations& observed, const Consensus& all,
                      const Solution& base) noexcept {
  const Sources out = observed.distrusted;
  const Sources suspects = all.present() & ~out;
  const Sources speeds = suspects & (wheels | only(Source::camera));
  std::array<Hypothesis, source_count + groups.size()> tried{};
  Hypothesis best{.score = base.misfit - gate};
  for (std::size_t i = 0; i < tried.size(); ++i) {
    const Hypothesis hypothesis =
        i < source_count ? Hypothesis{only(static_cast<Source>(i)), 0.0} : groups[i - source_count];
    const Sources sources = hypothesis.sources & suspects;
    if (sources == 0) {
      continue;
    }
    // Without its last speed the car has only what it integrates.
    const bool only_speed = (sources & speeds) != 0 && (speeds & ~sources) == 0;
    tried[i] = {sources, all.without(out | sources).misfit +
                             (only_speed ? group : hypothesis.score) -
                             (is_anomalous(observed, sources) ? anomaly_bonus : 0.0)};
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
