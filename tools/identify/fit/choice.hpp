// Chooses which of the numbers found go into a configuration: those that make a replay better, or
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

inline constexpr double as_good = 1.003;  ///< largest ratio that counts as no worse
inline constexpr double worth_it = 0.98;  ///< errors, by what more than a value must bring

[[nodiscard]] Patch together(Patch one, const Patch& other);

/// A group of values that go into the configuration together or not at all.
struct Candidate {
  std::string name;
  Patch patch;
  std::vector<std::size_t> findings;  ///< values to write
  std::optional<Finding> own;         ///< found by the trial itself
  bool taken = false;
};

/// The candidates taken, and the errors of a replay with them.
class Choice {
 public:
  /// `judge` returns the errors of a replay with a patch.
  Choice(std::function<Ratio(const Patch&)> judge, std::vector<Candidate> candidates);

  [[nodiscard]] const std::vector<Candidate>& candidates() const { return candidates_; }
  [[nodiscard]] const Ratio& now() const { return now_; }
  [[nodiscard]] Patch patch() const;

  /// The errors with one of them switched.
  [[nodiscard]] Ratio turned(std::size_t i);

  /// Adds one more, which is taken, and the errors with it.
  void take(Candidate candidate, const Ratio& with);

  /// Takes the best candidate to take, or if there is none drops the best one to drop, and returns
  /// which. It takes nothing that increases the errors, drops nothing unless that clearly reduces
  /// them, and does neither if it much increases those of a half; but a value found by the trial
  /// itself is dropped as soon as it does not pay off.
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
