#include "tools/identify/stiffness/film_motion.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <stdexcept>

#include <fmt/format.h>

#include "daemon/diagnostics/diagnostic.hpp"
#include "tools/cli/text.hpp"
#include "tools/math/median.hpp"

namespace odomd::tools {
namespace {

// Least squares of a complex path over the functions 1 and f(τ): the factor of f.
struct ComplexLine {
  Plane n{}, sum_f{}, sum_p{}, sum_fp{};
  double sum_ff = 0.0;

  void take(Plane f, Plane p) {
    n += 1.0;
    sum_f += f;
    sum_ff += std::norm(f);
    sum_p += p;
    sum_fp += std::conj(f) * p;
  }
  [[nodiscard]] Plane factor() const {
    return (sum_fp - std::conj(sum_f) * sum_p / n) / (sum_ff - std::norm(sum_f) / n.real());
  }
};

}  // namespace

FilmMotion film_motion(const MarkerTrack& track, const MarkerPlaces& places,
                       const FilmScale& scale) {
  if (!(places.distance() > 0.0))
    throw std::invalid_argument("--front and --rear: the markers must not be at the same place");
  if (track.frames.size() < 20)
    throw std::invalid_argument(
        fmt::format("{}: only {} with both markers; track both through the whole film", track.name,
                    counted(track.frames.size(), "frame")));
  std::vector<double> distances;
  distances.reserve(track.frames.size());
  for (const MarkerFrame& frame : track.frames)
    distances.push_back(std::abs(frame.front - frame.rear));
  const double apart = median_of(distances);
  if (!(apart > 0.0))
    throw std::invalid_argument(track.name +
                                ": front and rear marker are at the same place; "
                                "track two different markers");

  FilmMotion motion;
  motion.metres_per_unit =
      scale.from == FilmScale::From::given ? scale.metres_per_unit : places.distance() / apart;
  const double ratio = apart * motion.metres_per_unit / places.distance();
  if (std::abs(ratio - 1.0) > 0.05)
    throw std::invalid_argument(
        fmt::format("{}: the markers are {:.4g} m apart in the film, and {:.4g} m by --front and "
                    "--rear; correct the scale (--metres-per-pixel, --metres) or the places",
                    track.name, apart * motion.metres_per_unit, places.distance()));
  if (scale.from == FilmScale::From::given && std::abs(ratio - 1.0) > 3.0 * scale.ratio_sigma)
    motion.warnings.push_back(found(
        diagnostics::kind("film_scale_off"), track.name,
        fmt::format("by the scale the markers are {:.4g} m apart, {:.1f} % {} than the {:.4g} m of "
                    "--front and --rear",
                    apart * motion.metres_per_unit, 100.0 * std::abs(ratio - 1.0),
                    ratio > 1.0 ? "more" : "less", places.distance())));

  for (double& distance : distances) distance = std::abs(distance / apart - 1.0);
  // 1.48 median absolute deviations are a standard deviation
  const double limit = std::max(6.0 * 1.48 * median_of(distances), 0.02);
  std::size_t left_out = 0;
  double turned_before = 0.0;
  for (std::size_t i = 0; i < track.frames.size(); ++i) {
    if (distances[i] > limit) {
      ++left_out;
      continue;
    }
    MarkerFrame frame = track.frames[i];
    if (scale.axes == ImageAxes::y_down) {
      frame.front = std::conj(frame.front);
      frame.rear = std::conj(frame.rear);
    }
    const double heading = std::arg((frame.front - frame.rear) / (places.front - places.rear));
    turned_before += std::remainder(heading - turned_before, 2.0 * std::numbers::pi);
    motion.frames.push_back(
        {frame.t_ns,
         0.5 * motion.metres_per_unit * (frame.front + frame.rear) -
             0.5 * (places.front + places.rear) * std::polar(1.0, turned_before),
         turned_before});
  }
  if (5 * left_out > track.frames.size())
    throw std::invalid_argument(
        fmt::format("{}: in {} of {} frames the distance of the markers differs from that in the "
                    "others; was something else tracked there?",
                    track.name, left_out, track.frames.size()));
  if (track.gaps > 0)
    motion.warnings.push_back(found(diagnostics::kind("film_rows_left_out"), track.name,
                                    counted(track.gaps, "row") + " without both markers"));
  if (left_out > 0)
    motion.warnings.push_back(
        found(diagnostics::kind("film_rows_left_out"), track.name,
              counted(left_out, "frame") +
                  " left out, as the distance of the markers differs from that in the others"));
  return motion;
}

std::optional<LocalMotion> local_motion(const FilmMotion& motion, std::int64_t t_ns,
                                        std::int64_t half_ns) {
  const auto begin = std::ranges::lower_bound(motion.frames, t_ns - half_ns, {}, &BodyFrame::t_ns);
  const auto end =
      std::ranges::upper_bound(begin, motion.frames.end(), t_ns + half_ns, {}, &BodyFrame::t_ns);
  LocalMotion local;
  local.frames = static_cast<std::size_t>(end - begin);
  if (local.frames < 6) return std::nullopt;
  std::int64_t before = t_ns - half_ns;
  for (auto frame = begin; frame != end; ++frame) {
    if (frame->t_ns - before > 2 * half_ns / 3) return std::nullopt;
    before = frame->t_ns;
  }
  if (t_ns + half_ns - before > 2 * half_ns / 3) return std::nullopt;

  // Heading: ψ(τ) = ψ₀ + ψ̇ τ
  const auto n = static_cast<double>(local.frames);
  double mean_t = 0.0, mean_psi = 0.0;
  for (auto frame = begin; frame != end; ++frame) {
    mean_t += 1e-9 * static_cast<double>(frame->t_ns - t_ns) / n;
    mean_psi += frame->heading / n;
  }
  double tt = 0.0, tpsi = 0.0;
  for (auto frame = begin; frame != end; ++frame) {
    const double tau = 1e-9 * static_cast<double>(frame->t_ns - t_ns) - mean_t;
    tt += tau * tau;
    tpsi += tau * (frame->heading - mean_psi);
  }
  local.yaw_rate = tpsi / tt;
  local.heading = mean_psi - local.yaw_rate * mean_t;

  // Path: p(τ) = c + q f(τ) with f = (exp(i ψ̇ τ) - 1) / (i ψ̇), so that q is the velocity at τ = 0;
  // f = τ + i ψ̇ τ²/2 - … where ψ̇ τ is small.
  double residual = 0.0;
  ComplexLine path;
  for (auto frame = begin; frame != end; ++frame) {
    const double tau = 1e-9 * static_cast<double>(frame->t_ns - t_ns);
    const double turned = local.yaw_rate * tau;
    const double missed = frame->heading - local.heading - turned;
    residual += missed * missed;
    path.take(
        tau * Plane{std::abs(turned) < 1e-4 ? 1.0 : std::sin(turned) / turned,
                    std::abs(turned) < 1e-4 ? 0.5 * turned : (1.0 - std::cos(turned)) / turned},
        frame->centre);
  }
  local.velocity = path.factor();
  local.heading_residual = std::sqrt(residual / (n - 2.0));
  return local;
}

}  // namespace odomd::tools
