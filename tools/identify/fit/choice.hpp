// Which of the numbers that were found go into a configuration: those that make a replay better, or
// no worse.
#pragma once

#include <cstddef>
#include <cstdint>
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "tools/identify/common/finding.hpp"
#include "tools/identify/fit/judge.hpp"

namespace odomd::tools::fitting {

inline constexpr double as_good = 1.003;  ///< errors that are no worse
inline constexpr double worth_it = 0.98;  ///< errors, by what more than a value must bring

[[nodiscard]] Patch together(Patch one, const Patch& other);

/// What may go into the configuration, all of it or nothing.
struct Candidate {
  std::string name;
  Patch patch;
  std::vector<std::size_t> findings;  ///< that it puts in
  std::optional<Finding> own;         ///< what is found by the trial itself
  bool taken = false;
};

/// The candidates that are taken, and what a replay with them makes of the errors.
class Choice {
 public:
  /// `judge` tells the errors of a replay with a patch.
  Choice(std::function<Ratio(const Patch&)> judge, std::vector<Candidate> candidates);

  [[nodiscard]] const std::vector<Candidate>& candidates() const { return candidates_; }
  [[nodiscard]] const Ratio& now() const { return now_; }
  [[nodiscard]] Patch patch() const;

  /// The errors with one of them taken where it is left, and left where it is taken.
  [[nodiscard]] Ratio turned(std::size_t i);

  /// One more, which is taken, and the errors with it.
  void take(Candidate candidate, const Ratio& with);

  /// Takes the one that is best taken, or where none is, leaves the one that is best left, and says
  /// which. Nothing is taken that makes the errors more, nothing left where that does not make them
  /// clearly less, and neither where it makes those of a half much more; but what the trial found
  /// itself is left as soon as it is worth no more.
  std::optional<std::string> turn_best();

 private:
  enum class Way : std::uint8_t { in, out };
  struct Turn {
    std::size_t candidate = 0;
    Ratio then;
  };
  [[nodiscard]] std::optional<Turn> best(Way way);
  void turn(std::size_t i) { candidates_[i].taken = !candidates_[i].taken; }

  std::function<Ratio(const Patch&)> judge_;
  std::vector<Candidate> candidates_;
  Ratio now_;
};

}  // namespace odomd::tools::fitting
