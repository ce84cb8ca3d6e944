#include "tools/identify/stiffness/film.hpp"

#include <fmt/format.h>

#include <Eigen/Core>
#include <algorithm>
#include <cmath>
#include <numbers>
#include <sstream>
#include <string_view>

#include "tools/cli/csv.hpp"
#include "tools/cli/files.hpp"
#include "tools/cli/text.hpp"
#include "tools/diagnostics/kinds.hpp"
#include "tools/identify/common/refuse.hpp"
#include "tools/math/median.hpp"

namespace odomd::tools {
namespace {

constexpr std::int64_t smoothing_ns = 200'000'000;  // half of the window of a yaw rate

std::string_view trimmed(std::string_view text) {
  constexpr std::string_view blank = " \t\r\"";
  const std::size_t begin = text.find_first_not_of(blank);
  if (begin == std::string_view::npos) return {};
  return text.substr(begin, text.find_last_not_of(blank) - begin + 1);
}

// Splits a line at the first of tab, semicolon, comma and blank that it contains; if commas do not
// separate fields, they are decimal commas.
std::vector<std::string> fields_of(std::string_view line) {
  char separator = ' ';
  for (const char other : {',', ';', '\t'})
    if (line.find(other) != std::string_view::npos) separator = other;
  std::vector<std::string> fields;
  for (std::size_t begin = 0, end = 0; end < line.size() || begin == 0; begin = end + 1) {
    end = std::min(line.find(separator, begin), line.size());
    std::string field{trimmed(line.substr(begin, end - begin))};
    if (separator != ',') std::ranges::replace(field, ',', '.');
    if (separator != ' ' || !field.empty()) fields.push_back(std::move(field));
  }
  return fields;
}

std::string_view without_plus(std::string_view number) {
  return number.substr(number.starts_with('+') ? 1 : 0);
}

// The name without its unit: "x_front" for "x_front (px)".
std::string column_name(std::string name) {
  name.resize(std::min(name.find_first_of(" (["), name.size()));
  for (char& letter : name)
    if (letter >= 'A' && letter <= 'Z') letter = static_cast<char>(letter - 'A' + 'a');
  return name;
}

struct CsvText {
  std::string text;
  CsvLayout layout;
};

// The file in our CSV format with the same line numbers: comments and all headings but the last
// become blank.
CsvText as_csv(const std::filesystem::path& file, const std::vector<std::string>& columns) {
  constexpr std::size_t longest = 65'536;  // longer: no line ends, so not a track
  CsvText table;
  std::size_t heading_at = 0, line_number = 0, width = columns.size();
  if (columns.size() == 3) table.layout.header_line = 0;  // headings are optional
  std::vector<std::string> names;
  bool has_rows = false;
  std::istringstream lines(read_whole(file));
  for (std::string line; std::getline(lines, line); table.text += '\n') {
    if (++line_number == 1 && line.starts_with("\xEF\xBB\xBF"))
      line.erase(0, 3);  // byte order mark
    if (line.size() > longest)
      refuse("{}:{}: the line is longer than 64 KiB; is this a track?", file.string(), line_number);
    if (const auto text = trimmed(line); text.empty() || text.starts_with('#')) continue;
    std::vector<std::string> fields = fields_of(line);
    has_rows = has_rows || (!fields.empty() && parse_number(without_plus(fields.front())));
    if (!has_rows) {
      names = std::move(fields);
      heading_at = table.text.size();
      table.layout.header_line = line_number;
      width = names.size();
      continue;
    }
    fields.resize(width);
    table.text += joined(fields);
  }
  if (!has_rows)
    refuse(
        "{}: contains no row that begins with a number; export the track as a table with the "
        "columns {}",
        file.string(), joined(columns));
  std::ranges::transform(names, names.begin(), column_name);
  table.text.insert(heading_at, joined(names));
  return table;
}

struct Row {
  std::int64_t t_ns = 0;
  std::vector<std::optional<double>> values;  // of all columns but the first
};

std::int64_t time_in(const CsvReader& reader, std::optional<double> fps) {
  if (!fps) return reader.time_ns(0);
  const std::optional<double> frame = parse_number(reader.text(0));
  if (!frame || !(std::abs(*frame) < 1e9) || *frame != std::floor(*frame))
    reader.fail(0, tools::quoted(reader.text(0)) + " is not a frame number, which --fps requires");
  return std::llround(1e9 * *frame / *fps);
}

std::vector<Row> read_rows(const std::filesystem::path& file,
                           const std::vector<std::string>& columns, std::optional<double> fps) {
  const CsvText table = as_csv(file, columns);
  std::istringstream text(table.text);
  CsvReader reader(text, file.string(), columns, LastLine::keep_whole, table.layout);
  std::vector<Row> rows;
  while (reader.next()) {
    Row row{.t_ns = time_in(reader, fps)};
    if (!rows.empty() && row.t_ns <= rows.back().t_ns)
      reader.fail(0, tools::quoted(reader.text(0)) +
                         " is not later than the row before; sort the rows by time and remove "
                         "repeated ones");
    for (std::size_t k = 1; k < columns.size(); ++k) {
      const std::string_view field = reader.text(k);
      const auto value = row.values.emplace_back(parse_number(without_plus(field)));
      if (!field.empty() && !(value && std::isfinite(*value)))
        reader.fail(k, tools::quoted(field) +
                           " is not a finite number; leave the field empty if the marker was not "
                           "seen");
    }
    rows.push_back(std::move(row));
  }
  return rows;
}

// The track of rows with the positions of both markers.
MarkerTrack track_of(const std::filesystem::path& file, const std::vector<Row>& rows) {
  MarkerTrack track{.name = file.string()};
  for (const Row& row : rows) {
    const auto& v = row.values;
    if (v.size() == 4 && v[0] && v[1] && v[2] && v[3])
      track.frames.push_back({row.t_ns, Plane{*v[0], *v[1]}, Plane{*v[2], *v[3]}});
    else
      ++track.gaps;
  }
  return track;
}

}  // namespace

MarkerTrack read_marker_track(const std::filesystem::path& file, std::optional<double> fps) {
  return track_of(file, read_rows(file, {"t", "x_front", "y_front", "x_rear", "y_rear"}, fps));
}

MarkerTrack read_marker_tracks(const std::filesystem::path& front,
                               const std::filesystem::path& rear, std::optional<double> fps) {
  std::vector<Row> both = read_rows(front, {"t", "x", "y"}, fps);
  const std::vector<Row> others = read_rows(rear, {"t", "x", "y"}, fps);
  for (Row& row : both)
    if (const auto other = std::ranges::lower_bound(others, row.t_ns, {}, &Row::t_ns);
        other != others.end() && other->t_ns == row.t_ns)
      row.values.insert(row.values.end(), other->values.begin(), other->values.end());
  MarkerTrack track = track_of(front, both);
  if (track.frames.empty())
    refuse("{} and {} have no time in common; export both from the same film", front.string(),
           rear.string());
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
  const double apart = median_of(distances);
  if (!(apart > 0.0))
    refuse("{}: front and rear marker are at the same place; track two different markers",
           track.name);

  FilmMotion motion;
  motion.metres_per_unit = scale.metres_per_unit.value_or(places.distance() / apart);
  const double ratio = apart * motion.metres_per_unit / places.distance();
  if (std::abs(ratio - 1.0) > 0.05)
    refuse(
        "{}: the markers are {:.4g} m apart in the film, and {:.4g} m by --front and "
        "--rear; correct the scale (--metres-per-pixel, --metres) or the places",
        track.name, apart * motion.metres_per_unit, places.distance());
  if (scale.metres_per_unit && std::abs(ratio - 1.0) > 3.0 * scale.ratio_sigma)
    motion.warnings.push_back(found(
        tools::kind("film_scale_off"), track.name,
        fmt::format("by the scale the markers are {:.4g} m apart, {:.1f} % {} than the {:.4g} m of "
                    "--front and --rear",
                    apart * motion.metres_per_unit, 100.0 * std::abs(ratio - 1.0),
                    ratio > 1.0 ? "more" : "less", places.distance())));

  for (double& distance : distances) distance = std::abs(distance / apart - 1.0);
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
        "others; was something else tracked there?",
        track.name, left_out, track.frames.size());
  if (track.gaps > 0)
    motion.warnings.push_back(found(tools::kind("film_rows_left_out"), track.name,
                                    counted(track.gaps, "row") + " without both markers"));
  if (left_out > 0)
    motion.warnings.push_back(
        found(tools::kind("film_rows_left_out"), track.name,
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

  const auto n = static_cast<Eigen::Index>(local.frames);
  Eigen::ArrayXd tau(n), heading(n);
  Eigen::ArrayXcd path(n);
  for (Eigen::Index i = 0; i < n; ++i) {
    tau[i] = 1e-9 * static_cast<double>(begin[i].t_ns - t_ns);
    heading[i] = begin[i].heading;
    path[i] = begin[i].centre;
  }
  // ψ(τ) = ψ₀ + ψ̇ τ
  const Eigen::ArrayXd off = tau - tau.mean();
  local.yaw_rate = (off * (heading - heading.mean())).sum() / off.square().sum();
  local.heading = heading.mean() - local.yaw_rate * tau.mean();
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

YawRates yaw_rates_of(const FilmMotion& motion) {
  YawRates rates{motion.frames.front().t_ns, {}};
  for (std::int64_t t = rates.first_ns; t <= motion.frames.back().t_ns; t += YawRates::step_ns) {
    const auto local = local_motion(motion, t, smoothing_ns);
    rates.value.push_back(local ? local->yaw_rate : std::numeric_limits<double>::quiet_NaN());
  }
  return rates;
}

// The slope of a line through ψ over ±h weighs the rates with a parabola, as wide as the weights of
// a mean over ±h √(3/5).
YawRates yaw_rates_of(const Series& gyro) {
  YawRates rates{gyro.t_ns.front(), {}};
  const auto half_ns =
      static_cast<std::int64_t>(std::sqrt(0.6) * static_cast<double>(smoothing_ns));
  std::size_t begin = 0, end = 0;
  double sum = 0.0;
  for (std::int64_t t = rates.first_ns; t <= gyro.t_ns.back(); t += YawRates::step_ns) {
    for (; end < gyro.size() && gyro.t_ns[end] <= t + half_ns; ++end) sum += gyro.value[end];
    for (; begin < end && gyro.t_ns[begin] < t - half_ns; ++begin) sum -= gyro.value[begin];
    rates.value.push_back(end > begin ? sum / static_cast<double>(end - begin)
                                      : std::numeric_limits<double>::quiet_NaN());
  }
  return rates;
}

}  // namespace odomd::tools
