#include "tools/evaluation/closed_loop.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <stdexcept>

#include "tools/cli/text.hpp"
#include "tools/math/se2.hpp"

namespace odomd::tools {
namespace {

constexpr double least_path = 1.0;        // m
constexpr double refused_of_path = 0.10;  // end error
constexpr double refused_of_size = 0.5;
constexpr double refused_turn = 45.0;  // deg
constexpr double warn_share_of_path = 0.03;
constexpr double warn_turn = 20.0;  // deg

double degrees_off(const Evaluation& e) {
  return std::abs(e.heading_end) * 180.0 / std::numbers::pi;
}

// Largest ratio of an error to its limit; above 1 the lap is refused.
double excess(const Evaluation& e) {
  return std::max({e.end_error / (refused_of_path * e.path_length),
                   e.end_error / (refused_of_size * std::max(e.farthest, 1e-9)),
                   degrees_off(e) / refused_turn});
}

std::string how_far(const Evaluation& e) {
  return fixed(e.end_error, 2) + " m (" + fixed(100.0 * e.end_error / e.path_length, 1) + " % of " +
         fixed(e.path_length, 1) + " m) and " + fixed(degrees_off(e), 0) + " deg from its start";
}

bool closes_badly(const Evaluation& e) {
  return e.end_error > warn_share_of_path * e.path_length || degrees_off(e) > warn_turn;
}

const Evaluation& best_of(std::span<const Evaluation> evaluations) {
  return *std::ranges::min_element(evaluations, {}, [](const Evaluation& e) {
    return std::pair{e.path_length < least_path, excess(e)};
  });
}

}  // namespace

Evaluation evaluate_closed_loop(const Trajectory& estimate) {
  const auto& points = estimate.points;
  if (points.size() < 2) {
    throw std::invalid_argument(estimate.name + ": has one row only; a lap needs more");
  }
  Evaluation e;
  e.against = Against::closed_loop;
  e.name = estimate.name;
  e.samples = points.size();
  e.first_ns = points.front().t_ns;
  e.last_ns = points.back().t_ns;
  for (std::size_t i = 1; i < points.size(); ++i) {
    e.path_length += distance(points[i - 1].pose, points[i].pose);
    e.farthest = std::max(e.farthest, distance(points.front().pose, points[i].pose));
  }
  e.end_error = distance(points.front().pose, points.back().pose);
  e.heading_end =
      std::remainder(points.back().pose.yaw - points.front().pose.yaw, 2.0 * std::numbers::pi);
  if (e.path_length > 0.0) e.end_cm_per_m = 100.0 * e.end_error / e.path_length;
  return e;
}

bool closes(const Evaluation& loop) {
  return loop.path_length >= least_path && excess(loop) <= 1.0 && !closes_badly(loop);
}

Evaluation without_errors(const Evaluation& open) {
  Evaluation e = open;
  e.against = Against::nothing;
  e.end_error = e.heading_end = 0.0;
  e.end_cm_per_m.reset();
  return e;
}

std::optional<diagnostics::Diagnostic> check_that_it_closes(
    const std::string& drive, std::span<const Evaluation> evaluations) {
  const Evaluation* const best = &best_of(evaluations);
  if (best->path_length < least_path) {
    throw std::invalid_argument(drive + ": the car hardly moves (" + fixed(best->path_length, 2) +
                                " m); a closed loop needs a lap");
  }
  if (excess(*best) > 1.0) {
    throw std::invalid_argument(
        drive + ": the lap does not close: by the best estimate it ends " + how_far(*best) +
        "; cut it to whole laps with --from and --to, or give a --reference");
  }
  if (closes_badly(*best)) {
    return found(diagnostics::kind("loop_closes_badly"), drive,
                 "the lap closes badly: by the best estimate it ends " + how_far(*best));
  }
  return std::nullopt;
}

}  // namespace odomd::tools
