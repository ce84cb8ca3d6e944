#include "tools/identify/fit/choice.hpp"

#include <utility>

namespace odomd::tools::fitting {
namespace {

constexpr double better = 0.995;      // ratio of clearly smaller errors
constexpr double half_as_good = 1.1;  // largest ratio for each half

/// The largest allowed ratio of the errors with a change to those without it. Values found by the
/// trial itself must keep paying off.
double allowed(const Candidate& candidate) {
  if (candidate.own) return candidate.taken ? 1.0 / worth_it : worth_it;
  return candidate.taken ? better : as_good;
}

}  // namespace

Patch together(Patch one, const Patch& other) {
  one.insert(one.end(), other.begin(), other.end());
  return one;
}

Choice::Choice(std::function<Ratio(const Patch&)> judge, std::vector<Candidate> candidates)
    : judge_(std::move(judge)), candidates_(std::move(candidates)), now_(judge_({})) {}

Patch Choice::patch() const {
  Patch all;
  for (const Candidate& one : candidates_)
    if (one.taken) all = together(std::move(all), one.patch);
  return all;
}

Ratio Choice::turned(std::size_t i) {
  turn(i);
  const Ratio ratio = judge_(patch());
  turn(i);
  return ratio;
}

void Choice::take(Candidate candidate, const Ratio& with) {
  candidate.taken = true;
  candidates_.push_back(std::move(candidate));
  now_ = with;
}

std::optional<Choice::Turn> Choice::best(Way way) {
  std::optional<Turn> best;
  for (std::size_t i = 0; i < candidates_.size(); ++i) {
    if (candidates_[i].taken != (way == Way::out)) continue;
    const Ratio then = turned(i);
    const bool fits = then.all < allowed(candidates_[i]) * now_.all &&
                      then.half[0] <= half_as_good * now_.half[0] &&
                      then.half[1] <= half_as_good * now_.half[1];
    if (fits && (!best || then.all < best->then.all)) best = {i, then};
  }
  return best;
}

std::optional<std::string> Choice::turn_best() {
  std::optional<Turn> best = this->best(Way::in);
  if (!best) best = this->best(Way::out);
  if (!best) return std::nullopt;
  turn(best->candidate);
  now_ = best->then;
  const Candidate& one = candidates_[best->candidate];
  return (one.taken ? "" : "without ") + one.name;
}

}  // namespace odomd::tools::fitting
