#include "tools/identify/stiffness/film.hpp"

#include <fmt/format.h>

#include <Eigen/Core>
#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <numbers>

#include "tools/cli/csv.hpp"
#include "tools/cli/files.hpp"
#include "tools/cli/text.hpp"
#include "tools/diagnostics/kinds.hpp"
#include "tools/identify/common/agreement.hpp"
#include "tools/identify/common/finding.hpp"
#include "tools/math/median.hpp"

namespace odomd::tools {

MarkerTrack read_marker_track(const std::filesystem::path& file) {
  std::ifstream input = open_input(file);
  CsvReader rows(input, file.string(), {"t", "x_front", "y_front", "x_rear", "y_rear"});
  MarkerTrack track{.name = file.string()};
  std::int64_t before = std::numeric_limits<std::int64_t>::min();
  while (rows.next()) {
    const std::int64_t t_ns = rows.time_ns(0);
    if (t_ns <= before)
      rows.fail(0, tools::quoted(rows.text(0)) +
                       " is not later than the row before; sort the rows by time and remove "
                       "repeated ones");
    before = t_ns;
    std::array<double, 4> value{};
    bool seen = true;
    for (std::size_t k = 0; k < value.size(); ++k) {
      seen = seen && !rows.text(k + 1).empty();
      if (!rows.text(k + 1).empty()) value.at(k) = rows.number(k + 1);
    }
    if (seen)
      track.frames.push_back({t_ns, Plane{value[0], value[1]}, Plane{value[2], value[3]}});
    else
      ++track.gaps;
  }
  return track;
}

// The motion from a track.

FilmMotion film_motion(const MarkerTrack& track, const MarkerPlaces& places,
                       const FilmScale& scale) {
  if (!(places.distance() > 0.0))
    refuse("--front and --rear: the markers must not be at the same place");
  if (track.frames.size() < 20)
    refuse("{}: only {} with both markers; track both through the whole film", track.name,
           counted(track.frames.size(), "frame"));
  std::vector<double> distances;
  distances.reserve(track.frames.size());
  for (const MarkerFrame& frame : track.frames)
    distances.push_back(std::abs(frame.front - frame.rear));
  const double spacing = median_of(distances);
  if (!(spacing > 0.0))
    refuse("{}: front and rear marker are at the same place; track two different markers",
           track.name);

  FilmMotion motion;
  motion.metres_per_unit = scale.metres_per_unit.value_or(places.distance() / spacing);
  const double ratio = spacing * motion.metres_per_unit / places.distance();
  if (std::abs(ratio - 1.0) > 0.05)
    refuse(
        "{}: the markers are {:.4g} m apart in the film, but {:.4g} m according to --front and "
        "--rear; correct the scale (--metres-per-pixel, --metres) or the places",
        track.name, spacing * motion.metres_per_unit, places.distance());
  if (scale.metres_per_unit && std::abs(ratio - 1.0) > 3.0 * scale.ratio_sigma)
    add_warning(
        motion.warnings, tools::kind("film_scale_off"), track.name,
        "with the given scale the markers are {:.4g} m apart, {:.1f} % {} than the {:.4g} m of "
        "--front and --rear",
        spacing * motion.metres_per_unit, 100.0 * std::abs(ratio - 1.0),
        ratio > 1.0 ? "more" : "less", places.distance());

  for (double& distance : distances) distance = std::abs(distance / spacing - 1.0);
  // A standard deviation is 1.48 median absolute deviations.
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
    refuse(
        "{}: in {} of {} frames the distance of the markers differs from that in the "
        "others; was another object tracked there?",
        track.name, left_out, track.frames.size());
  if (track.gaps > 0)
    add_warning(motion.warnings, tools::kind("film_rows_left_out"), track.name,
                "{} without both markers", counted(track.gaps, "row"));
  if (left_out > 0)
    add_warning(motion.warnings, tools::kind("film_rows_left_out"), track.name,
                "{} left out, as the distance of the markers differs from that in the others",
                counted(left_out, "frame"));
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

  const auto n = static_cast<Eigen::Index>(local.frames);
  Eigen::ArrayXd tau(n), heading(n);
  Eigen::ArrayXcd path(n);
  for (Eigen::Index i = 0; i < n; ++i) {
    tau[i] = 1e-9 * static_cast<double>(begin[i].t_ns - t_ns);
    heading[i] = begin[i].heading;
    path[i] = begin[i].centre;
  }
  // ψ(τ) = ψ₀ + ψ̇ τ
  const Relation line = relation_of(heading, tau);
  local.yaw_rate = line.slope;
  local.heading = line.offset;
  const Eigen::ArrayXd turned = local.yaw_rate * tau;
  local.heading_residual =
      std::sqrt((heading - local.heading - turned).square().sum() / static_cast<double>(n - 2));
  // p(τ) = c + q f(τ) with f = (exp(i ψ̇ τ) - 1) / (i ψ̇), so q is the velocity at τ = 0; for small
  // ψ̇ τ f = τ + i ψ̇ τ²/2 - …
  Eigen::ArrayXcd f = tau * turned.unaryExpr([](double angle) {
    return std::abs(angle) < 1e-4 ? Plane{1.0, 0.5 * angle}
                                  : Plane{std::sin(angle) / angle, (1.0 - std::cos(angle)) / angle};
  });
  f -= f.mean();
  local.velocity = (f.conjugate() * (path - path.mean())).sum() / f.abs2().sum();
  return local;
}

}  // namespace odomd::tools
