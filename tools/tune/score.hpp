// The errors of settings on a drive, and how much better they are than others.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>
#include <string>
#include <string_view>

#include "tools/evaluation/evaluation.hpp"

namespace odomd::tools {

/// Errors that tuning may reduce.
enum class Goal : std::uint8_t {
  position,    ///< rms [m]
  heading,     ///< rms [rad]
  prediction,  ///< mean over 35 ms [m]
  second,      ///< mean over 1 s [m]
  end,         ///< error at the end, per metre [cm/m]
  nees,        ///< consistency of the sigmas: the factor between the mean NEES and 3
  nis,         ///< of the innovations: Evaluation::nis_factor; needs neither truth nor camera
  count
};
inline constexpr std::size_t goal_count = static_cast<std::size_t>(Goal::count);
inline constexpr std::array<std::string_view, goal_count> goal_names{
    "position", "heading", "prediction", "second", "end", "nees", "nis"};

/// By Goal; NaN if the drive does not determine it. For Goal::nees it is the mean NEES itself,
/// which distinguishes too confident from too cautious.
using Score = std::array<double, goal_count>;

/// The mean NEES of consistent sigmas, for x, y and yaw.
inline constexpr double honest_nees = 3.0;

/// Why a drive may not determine it, and the fix.
[[nodiscard]] std::string why_unknown(Goal goal);

[[nodiscard]] Score score_of(const Evaluation& evaluation);

/// The error of `tried` over that of `before`: the geometric mean of the ratios over drives and
/// goals, so that no drive weighs more for being long or hard. 1: as good; 0.9: a tenth better.
/// What a drive did not determine before does not count; what it no longer determines is infinitely
/// bad.
[[nodiscard]] double relative_error(std::span<const Score> tried, std::span<const Score> before,
                                    std::span<const Goal> goals);

/// The relative error in one goal, to judge whether it is worse: as above, but sigmas may become
/// too large, for that deceives nobody. A NEES below 3 counts as 3.
[[nodiscard]] double judged_error(std::span<const Score> tried, std::span<const Score> before,
                                  Goal goal);

/// The judged error above which a goal is worse; less is chance. The mean NEES of a drive scatters
/// more than its errors.
[[nodiscard]] constexpr double worse_above(Goal goal) {
  return goal == Goal::nees ? 1.2 : 1.01;
}

}  // namespace odomd::tools
