// How well settings did on a drive, and by what that makes them better than others.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>
#include <string>
#include <string_view>

#include "tools/evaluation/evaluation.hpp"

namespace odomd::tools {

/// Errors that tuning may lessen.
enum class Goal : std::uint8_t {
  position,    ///< rms [m]
  heading,     ///< rms [rad]
  prediction,  ///< mean over 35 ms [m]
  second,      ///< mean over 1 s [m]
  end,         ///< error at the end, per metre [cm/m]
  nees,        ///< how far the sigmas are from honest: the factor between the mean NEES and 3
  count
};
inline constexpr std::size_t goal_count = static_cast<std::size_t>(Goal::count);
inline constexpr std::array<std::string_view, goal_count> goal_names{
    "position", "heading", "prediction", "second", "end", "nees"};

/// By Goal; NaN where the drive does not tell. Of Goal::nees it is the mean NEES itself, so that
/// too confident and too modest are told apart.
using Score = std::array<double, goal_count>;

/// The mean NEES of honest sigmas: of x, y and yaw.
inline constexpr double honest_nees = 3.0;

/// Why a drive may not tell it, and the mend; empty where all do.
[[nodiscard]] std::string why_untold(Goal goal);

[[nodiscard]] Score score_of(const Evaluation& evaluation);

/// The error of `tried` over that of `before`: the geometric mean of the ratios over drives and
/// goals, so that no drive weighs more for being long or hard. 1: as good; 0.9: a tenth better.
/// What a drive did not tell before does not count; what it no longer tells is infinitely bad.
[[nodiscard]] double relative_error(std::span<const Score> tried, std::span<const Score> before,
                                    std::span<const Goal> goals);

}  // namespace odomd::tools
