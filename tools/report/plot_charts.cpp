#include "tools/report/figures.hpp"

#include <algorithm>
#include <array>
#include <chrono>
#include <cmath>
#include <limits>
#include <nlohmann/json.hpp>
#include <sstream>
#include <stdexcept>
#include <utility>

#include "daemon/core/record.hpp"
#include "tools/chart/chart.hpp"
#include "tools/cli/files.hpp"
#include "tools/cli/output.hpp"
#include "tools/drive_files/pose_csv.hpp"
#include "tools/evaluation/evaluation_report.hpp"
#include "tools/live/daemon_link.hpp"
#include "tools/live/tick_follower.hpp"

namespace odomd::tools {
namespace {

using chart::Chart;
using chart::PlotSeries;

using Value = double (*)(const TrajectoryPoint&);

// A curve of a quantity: from the trajectory, or from a further column of the pose file. The curves
// of one quantity are drawn below each other.
struct Curve {
  std::string_view quantity;
  std::string_view title;
  std::string_view label;
  Value value = nullptr;
  bool Trajectory::*needs = nullptr;  // null: every trajectory has the value
  std::string_view column;
  double factor = 1.0;
};

double sigma(const TrajectoryPoint& p, std::size_t variance) {
  return std::sqrt(std::max(p.covariance[variance], 0.0));
}

const std::vector<Curve>& all_curves() {
  using P = const TrajectoryPoint&;
  static const std::vector<Curve> all = [] {
    constexpr auto motion = &Trajectory::has_motion;
    constexpr auto covariance = &Trajectory::has_covariance;
    std::vector<Curve> curves{
        {"speed", "Speed", "v_x [m/s]", [](P p) { return p.motion.v_x; }, motion},
        {"lateral_speed", "Lateral speed", "v_y [m/s]", [](P p) { return p.motion.v_y; }, motion},
        {"yaw_rate", "Yaw rate", "yaw rate [deg/s]",
         [](P p) { return p.motion.yaw_rate * degrees; }, motion},
        {"heading", "Heading", "yaw, unwrapped [deg]", [](P p) { return p.pose.yaw * degrees; }},
        {"steering", "Steering", "at the front wheels [deg]", {}, {}, "steering", degrees},
        {"acceleration", "Acceleration along x", "accel_x [m/s²]", {}, {}, "accel_x"},
        {"acceleration", "Acceleration along y", "accel_y [m/s²]", {}, {}, "accel_y"},
        {"sigma", "Standard deviation of x", "sigma_x [mm]", [](P p) { return 1e3 * sigma(p, 0); },
         covariance},
        {"sigma", "Standard deviation of y", "sigma_y [mm]", [](P p) { return 1e3 * sigma(p, 3); },
         covariance},
        {"sigma", "Standard deviation of the heading", "sigma_yaw [deg]",
         [](P p) { return degrees * sigma(p, 5); }, covariance},
    };
    constexpr std::array<std::pair<const char*, double>, daemon::calibrations.size()> units{
        {{"deg/s", degrees},
         {"1: exact", 1.0},
         {"m/s²", 1.0},
         {"m/s²", 1.0},
         {"1: exact", 1.0},
         {"deg", degrees},
         {"1: as configured", 1.0},
         {"ms", 1e3},
         {"ms", 1e3},
         {"ms", 1e3},
         {"m/s²", 1.0}}};
    for (std::size_t i = 0; i < units.size(); ++i) {
      const std::string_view name = daemon::calibrations[i].name;
      curves.push_back({"calibrations", name, units[i].first, {}, {}, name, units[i].second});
    }
    return curves;
  }();
  return all;
}

// A track with its name, colour and start; in a list, the reference, if any, comes first.
struct Drawn {
  const Trajectory* track;
  std::string name;
  std::string colour;
  double stroke;
  std::int64_t zero_ns;
};

std::vector<Drawn> drawn(const PlotInput& input) {
  std::vector<Drawn> all;
  std::vector<std::string> files;
  for (const Trajectory& track : input.tracks) files.push_back(track.name);
  const auto names = short_names(files);
  if (input.reference)
    all.push_back({&*input.reference, "reference", chart::reference_colour, 7.0, 0});
  for (std::size_t i = 0; i < input.tracks.size(); ++i)
    all.push_back({&input.tracks[i], names[i], chart::colour_of(i), 3.0, 0});
  std::int64_t first_ns = std::numeric_limits<std::int64_t>::max();
  for (Drawn& one : all) {
    one.zero_ns = one.track->points.front().t_ns;
    first_ns = std::min(first_ns, one.zero_ns);
  }
  if (!overlap(input)) return all;
  for (Drawn& one : all) one.zero_ns = first_ns;
  return all;
}

const std::vector<double>& values_of(const Trajectory& track, std::string_view column) {
  const std::vector<std::string> columns = plot_columns();
  return track.columns.at(
      static_cast<std::size_t>(std::ranges::find(columns, column) - columns.begin()));
}

constexpr std::string_view sigma_prefix = "sigma_";

// Three standard deviations around a curve of calibrations; empty if they were never estimated.
chart::Band band_of(const Curve& curve, const Trajectory& track, const PlotSeries& series) {
  chart::Band band{"±3σ", series.colour, {}};
  const auto& sigmas = values_of(track, std::string{sigma_prefix}.append(curve.column));
  if (std::ranges::none_of(sigmas, [](double sigma) { return sigma > 0.0; })) return band;
  for (std::size_t i = 0; i < sigmas.size(); ++i) {
    const auto& [x, y] = series.points[i];
    const double reach = 3.0 * curve.factor * (sigmas[i] > 0.0 ? sigmas[i] : std::nan(""));
    band.points.push_back({x, y - reach, y + reach});
  }
  return band;
}

// Draws the curve of every track that has its data.
Chart chart_of(const Curve& curve, const std::vector<Drawn>& tracks, const Calibrations& truth) {
  Chart chart = time_chart(std::string{curve.title}, std::string{curve.label});
  if (curve.needs == &Trajectory::has_covariance) chart.y.scaling = chart::Scaling::logarithmic;
  if (curve.quantity == "calibrations") chart.height = 200.0;
  for (const Drawn& one : tracks) {
    const Trajectory& track = *one.track;
    const std::vector<double>* const column =
        curve.value == nullptr ? &values_of(track, curve.column) : nullptr;
    if (column != nullptr ? column->empty() : curve.needs != nullptr && !(track.*curve.needs))
      continue;
    PlotSeries series = over_time(
        {one.name, "", one.colour, {}, chart::Mark::line, one.stroke}, track.points, one.zero_ns,
        [&](const TrajectoryPoint& point) -> std::optional<double> {
          if (column == nullptr) return curve.value(point);
          return (*column)[static_cast<std::size_t>(&point - track.points.data())] * curve.factor;
        });
    if (curve.quantity == "calibrations") {
      chart::Band band = band_of(curve, track, series);
      if (!chart.bands.empty()) band.label.clear();
      if (!band.points.empty()) chart.bands.push_back(std::move(band));
    }
    chart.series.push_back(std::move(series));
  }
  if (const auto known = truth.find(curve.column); known != truth.end())
    chart.levels.push_back({known->second * curve.factor, "true"});
  return chart;
}

chart::Drawing map_of(const PlotInput& input) {
  chart::Chart map = empty_map("");
  for (const Drawn& one : drawn(input)) {
    PlotSeries series{one.name, "", one.colour, {}, chart::Mark::line, one.stroke};
    for (const TrajectoryPoint& p : one.track->points)
      series.points.push_back({p.pose.x, p.pose.y});
    map.series.push_back(std::move(series));
  }
  return draw(map);
}

std::string what_is_missing(std::string_view quantity) {
  if (quantity == "sigma") return R"(columns "sigma_x", "sigma_y", "sigma_yaw" of the map's pose)";
  if (quantity == "calibrations") return R"(calibrations (column "gyro_bias", ...))";
  if (quantity == "steering") return R"(column "steering")";
  if (quantity == "acceleration") return R"(columns "accel_x", "accel_y")";
  return R"(columns "vx", "vy", "yaw_rate")";
}

}  // namespace

Calibrations true_calibrations(const std::filesystem::path& folder) {
  const std::filesystem::path file = folder / "plant.json";
  if (!std::filesystem::exists(file)) return {};
  auto input = open_input(file);
  try {
    const auto plant = nlohmann::json::parse(input);
    if (!plant.contains("truth")) return {};
    const auto of = [&](const char* name) { return plant.at("truth").at(name).get<double>(); };
    return {
        {"gyro_bias", of("gyro_bias")},
        {"gyro_scale", 1.0 + of("gyro_scale_error")},
        {"accel_bias_x", of("accel_bias_x")},
        {"accel_bias_y", of("accel_bias_y")},
        {"wheel_scale", 1.0 / (1.0 + of("wheel_radius_error"))},
        {"steering_offset", of("steering_offset")},
        {"stiffness_scale", 1.0 + 0.5 * (of("stiffness_error_front") + of("stiffness_error_rear"))},
        {"gyro_latency", of("gyro_latency")},
        {"wheel_latency", of("wheel_latency")},
        // The latency of a commanded steering includes the actuator's delay and lag.
        {"steering_latency",
         of("steering_latency") +
             of("steering_commanded") * (of("steering_delay") + of("steering_lag"))}};
  } catch (const nlohmann::json::exception& error) {
    throw std::invalid_argument(file.string() + ": is not a plant.json of odom sim: " +
                                error.what() + "; remove it or drive again");
  }
}

LiveTrack follow_daemon(const std::string& shm, double seconds, Frame frame,
                        const std::vector<std::string>& further) {
  using std::chrono::steady_clock;
  const std::string header = record_header();
  std::string text = header;
  TickFollower follower{attach(shm, 0.0)};
  Interrupt interrupt;
  daemon::TickRecord record;
  const auto end = steady_clock::now() + std::chrono::duration<double>(seconds);
  while (!interrupt.requested() && steady_clock::now() < end) {
    // Calibrations change slowly: the newest apply to all ticks of a batch.
    const auto newest = follower.client().latest_details();
    if (newest.has_value()) record.details = newest->details;
    (void)follower.follow(std::chrono::milliseconds{100}, [&](const odom_pose& pose) {
      if (pose.mode == ODOM_INITIALISING) return;
      record.pose = pose;
      append_record_row(text, record, pose.time_ns);
    });
  }
  const std::string name = segment_asked_for(shm);
  if (text.size() == header.size()) {
    throw std::runtime_error(name + ": no pose was published; check odom status");
  }
  LiveTrack live;
  if (const auto beat = follower.client().beat(); beat.has_value()) live.beat = *beat;
  std::istringstream rows(text);
  live.track = read_trajectory(rows, name, frame, further);
  return live;
}

std::vector<std::string> plot_quantities() {
  std::vector<std::string> names{"trajectory"};
  for (const Curve& curve : all_curves())
    if (names.back() != curve.quantity) names.emplace_back(curve.quantity);
  return names;
}

std::vector<std::string> plot_columns() {
  std::vector<std::string> names;
  for (const Curve& curve : all_curves()) {
    if (!curve.column.empty()) names.emplace_back(curve.column);
    if (curve.quantity == "calibrations")
      names.push_back(std::string{sigma_prefix}.append(curve.column));
  }
  return names;
}

bool overlap(const PlotInput& input) {
  std::int64_t latest_start = std::numeric_limits<std::int64_t>::min();
  std::int64_t earliest_end = std::numeric_limits<std::int64_t>::max();
  const auto take = [&](const Trajectory& track) {
    latest_start = std::max(latest_start, track.points.front().t_ns);
    earliest_end = std::min(earliest_end, track.points.back().t_ns);
  };
  if (input.reference) take(*input.reference);
  for (const Trajectory& track : input.tracks) take(track);
  return latest_start <= earliest_end;
}

std::vector<chart::Drawing> plot(std::string_view quantity, const PlotInput& input) {
  if (quantity == "trajectory") return {map_of(input)};
  std::vector<chart::Drawing> drawings;
  const std::vector<Drawn> tracks = drawn(input);
  for (const Curve& curve : all_curves()) {
    if (curve.quantity != quantity) continue;
    const Chart chart = chart_of(curve, tracks, input.truth);
    // A chart of the reference alone is left out.
    const auto is_reference = [](const PlotSeries& series) {
      return series.colour == chart::reference_colour;
    };
    if (!std::ranges::all_of(chart.series, is_reference)) drawings.push_back(draw(chart));
  }
  if (drawings.empty())
    throw std::invalid_argument(input.tracks.front().name + ": has no " +
                                what_is_missing(quantity) + "; use a file of odom replay");
  if (quantity == "calibrations") return chart::in_pairs(drawings);  // on one page
  return drawings;
}

}  // namespace odomd::tools
