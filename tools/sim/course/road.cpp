#include "tools/sim/course/road.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace odomd::sim {
namespace {

constexpr double hill = 160.0;         // about so long from top to top [m]
constexpr double full_bank_at = 45.0;  // a curve of this radius has all of the bank [m]
constexpr double transition = 8.0;     // the bank is a mean over so much on both sides [m]

double grade_at(const RoadProfile& profile, const Track& track, double s) {
  const double hills = std::max(1.0, std::round(track.length() / hill));
  const double part = s / track.length();
  // Two waves, one of them longer, with the sum within the grade.
  return profile.grade * (0.7 * std::sin(2.0 * std::numbers::pi * hills * part) +
                          0.3 * std::sin(2.0 * std::numbers::pi * part));
}

double bank_at(const RoadProfile& profile, const Track& track, double s) {
  double curvature = 0.0;
  for (const double offset : {-1.0, -0.5, 0.0, 0.5, 1.0})
    curvature += 0.2 * track.at(s + offset * transition).curvature;
  return -profile.bank * std::clamp(full_bank_at * curvature, -1.0, 1.0);
}

}  // namespace

RoadTilt tilt_at(const RoadProfile& profile, const Track& track, double s, double speed) {
  if (profile.is_level() || track.shape() == Shape::open) return {};
  constexpr double apart = 0.5;
  const double ahead = s + 0.5 * apart, behind = s - 0.5 * apart;
  const double along = speed / apart;
  return {
      .grade = std::atan(grade_at(profile, track, s)),
      .bank = bank_at(profile, track, s),
      .grade_rate = along * (grade_at(profile, track, ahead) - grade_at(profile, track, behind)),
      .bank_rate = along * (bank_at(profile, track, ahead) - bank_at(profile, track, behind))};
}

}  // namespace odomd::sim
