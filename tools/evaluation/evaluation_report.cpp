#include "tools/evaluation/evaluation_report.hpp"

#include <algorithm>
#include <array>
#include <charconv>
#include <nlohmann/json.hpp>
#include <set>
#include <string_view>

#include "tools/cli/csv.hpp"
#include "tools/cli/text.hpp"
#include "tools/math/se2.hpp"

namespace odomd::tools {
namespace {

using Json = nlohmann::ordered_json;
constexpr std::array<std::string_view, 4> against_names{"truth", "camera", "closed_loop",
                                                        "nothing"};

constexpr std::array<std::string_view, 3> align_names{"first", "fit", "none"};

// The double nearest to the decimal stamp: nanoseconds since 1970 do not fit a double, and dividing
// a rounded one may give a neighbour.
double stamp(std::int64_t time_ns) {
  std::string text;
  append_seconds(text, time_ns);
  double seconds = 0.0;
  std::from_chars(text.data(), text.data() + text.size(), seconds);
  return seconds;
}

Json spread(const Spread& value) {
  return {{"mean", value.mean}, {"rms", value.rms}, {"max", value.max}};
}

Json or_null(const std::optional<double>& value) {
  return value ? Json(*value) : Json(nullptr);
}

Json horizon(const HorizonError& e) {
  return {{"position", spread(e.displacement)}, {"yaw", spread(e.yaw)}, {"samples", e.samples}};
}

void add_reference_figures(const Evaluation& e, Json& json) {
  json["alignment"] = {e.alignment.x, e.alignment.y, e.alignment.yaw};
  json["position"] = spread(e.position);
  if (e.against == Against::camera) json["reference_noise"] = e.reference_noise;
  json["heading"]["rms"] = e.heading.rms;
  json["heading"]["max"] = e.heading.max;
  const HorizonError* const short_term = error_over(e, short_horizon_ns);
  json["error_35ms"] = short_term != nullptr ? horizon(*short_term) : Json(nullptr);
  json["horizons"] = Json::array();
  for (const HorizonError& error : e.horizons) {
    Json one{{"horizon", static_cast<double>(error.horizon_ns) / 1e9}};
    one.update(horizon(error));
    json["horizons"].push_back(std::move(one));
  }
  json["nees"] = nullptr;
  if (e.consistency)
    json["nees"] = {{"mean", e.consistency->nees},
                    {"inside_95", e.consistency->inside_95},
                    {"samples", e.consistency->samples}};
  if (e.velocity_rms) {
    json["velocity_rms"] = {{"vx", e.velocity_rms->v_x},
                            {"vy", e.velocity_rms->v_y},
                            {"yaw_rate", e.velocity_rms->yaw_rate}};
  }
}

Json json_of(const Evaluation& e, const Evaluation* baseline) {
  Json json{{"pose", e.name},
            {"samples", e.samples},
            {"t_first", stamp(e.first_ns)},
            {"t_last", stamp(e.last_ns)},
            {"duration", static_cast<double>(e.last_ns - e.first_ns) / 1e9},
            {"path_length", e.path_length},
            {"nis_factor", or_null(e.nis_factor)}};
  if (e.against == Against::nothing) return json;
  json["end_error"] = e.end_error;
  json["end_error_cm_per_m"] = or_null(e.end_cm_per_m);
  json["heading"]["end"] = e.heading_end;
  if (has_reference(e.against)) add_reference_figures(e, json);
  if (baseline == nullptr) return json;
  const auto better = [&](std::string_view label) {
    return or_null(metric(label).value(e, *baseline));
  };
  Json percent{{"against", baseline->name},
               {"end_error", better("end error better by [%]")},
               {"heading_end", better("heading end better by [%]")}};
  if (has_reference(e.against)) {
    percent["position_rms"] = better("position rms better by [%]");
    percent["heading_rms"] = or_null(improvement(e.heading.rms, baseline->heading.rms));
    percent["error_35ms_mean"] = better("35 ms error mean better by [%]");
  }
  json["improvement_percent"] = std::move(percent);
  return json;
}

using E = const Evaluation&;
using Value = Metric::Value;

Value if_known(bool known, double value) {
  return known ? Value(value) : std::nullopt;
}

// Only with a reference.
Value against_reference(E e, double value) {
  return if_known(has_reference(e.against), value);
}

Value mean_over(E e, std::int64_t horizon_ns, Spread HorizonError::*error, double factor) {
  const HorizonError* const found = error_over(e, horizon_ns);
  return found == nullptr ? std::nullopt : Value(factor * (found->*error).mean);
}

Value velocity(E e, double estimator::BodyVelocity::*component, double factor = 1.0) {
  return e.velocity_rms ? Value(factor * (*e.velocity_rms).*component) : std::nullopt;
}

// Of magnitudes.
Value better(E e, E baseline, Value value, Value before, double usual = 0.0) {
  if (&e == &baseline || !value || !before) return std::nullopt;
  return improvement(std::abs(*value), std::abs(*before), usual);
}

constexpr std::int64_t second_ns = 1'000'000'000;
constexpr auto displacement = &HorizonError::displacement;
constexpr std::string_view smaller =
    "how much smaller this error is than the baseline's; negative: larger";

constexpr std::array<Metric, 22> all_metrics{{
    {"samples", 0, "instants that were compared",
     [](E e, E) { return Value(static_cast<double>(e.samples)); }},
    {"time span [s]", 3, "from the first compared instant to the last",
     [](E e, E) { return Value(static_cast<double>(e.last_ns - e.first_ns) * 1e-9); }},
    {"path length [m]", 3, "distance driven along the reference, or along the estimate without one",
     [](E e, E) { return Value(e.path_length); }},
    {"end error [m]", 4,
     "distance of the last pose from the reference's, or from the start of a closed loop",
     [](E e, E) { return if_known(e.against != Against::nothing, e.end_error); }},
    {"end error [cm/m]", 3, "end error per metre of the path: per cent of the distance driven",
     [](E e, E) { return e.end_cm_per_m; }},
    {"position rms [m]", 4,
     "root of the mean squared distance from the reference; without the noise of a camera that is "
     "the reference",
     [](E e, E) { return against_reference(e, e.position.rms); }},
    {"position max [m]", 4, "the largest distance from the reference",
     [](E e, E) { return against_reference(e, e.position.max); }},
    {"heading error at the end [deg]", 3,
     "heading minus the reference's heading at the end, including whole turns",
     [](E e, E) { return if_known(e.against != Against::nothing, degrees * e.heading_end); }},
    {"heading error rms [deg]", 3, "root mean square of the heading error",
     [](E e, E) { return against_reference(e, degrees * e.heading.rms); }},
    {"heading error max [deg]", 3, "largest magnitude of the heading error",
     [](E e, E) { return against_reference(e, degrees * e.heading.max); }},
    // For these errors the JSON also has rms and maximum, and further horizons.
    {"35 ms error mean [mm]", 3,
     "error of the displacement over seven ticks of 5 ms, in the body frame: what a controller "
     "sees between two commands",
     [](E e, E) { return mean_over(e, short_horizon_ns, displacement, 1e3); }},
    {"35 ms yaw error mean [deg]", 3, "error of the turn over seven ticks of 5 ms",
     [](E e, E) { return mean_over(e, short_horizon_ns, &HorizonError::yaw, degrees); }},
    {"1000 ms error mean [mm]", 3, "error of the displacement over a second, in the body frame",
     [](E e, E) { return mean_over(e, second_ns, displacement, 1e3); }},
    {"NEES mean (expected: 3)", 3,
     "squared error over the filter's own covariance, of x, y and yaw. 3: the sigmas fit the "
     "errors; above: too small. None if the alignment removes what the filter did not know at "
     "the start",
     [](E e, E) { return e.consistency ? Value(e.consistency->nees) : std::nullopt; }},
    {"NIS factor (expected: 1)", 2,
     "by what factor the squared innovations are off what the filter expects, as geometric mean "
     "over the sources. Needs no reference",
     [](E e, E) { return e.nis_factor; }},
    {"vx rms [m/s]", 4, "root mean square of the error of the speed along the car",
     [](E e, E) { return velocity(e, &estimator::BodyVelocity::v_x); }},
    {"vy rms [m/s]", 4, "root mean square of the error of the speed to the left",
     [](E e, E) { return velocity(e, &estimator::BodyVelocity::v_y); }},
    {"yaw rate rms [deg/s]", 4, "root mean square of the error of the yaw rate",
     [](E e, E) { return velocity(e, &estimator::BodyVelocity::yaw_rate, degrees); }},
    {"end error better by [%]", 1, smaller,
     [](E e, E b) { return better(e, b, e.end_error, b.end_error, b.position.rms); }},
    {"position rms better by [%]", 1, smaller,
     [](E e, E b) { return better(e, b, e.position.rms, b.position.rms); }},
    {"heading end better by [%]", 1, smaller,
     [](E e, E b) { return better(e, b, e.heading_end, b.heading_end, b.heading.rms); }},
    {"35 ms error mean better by [%]", 1, smaller,
     [](E e, E b) {
       return better(e, b, mean_over(e, short_horizon_ns, displacement, 1.0),
                     mean_over(b, short_horizon_ns, displacement, 1.0));
     }},
}};

}  // namespace

std::span<const Metric> metrics() {
  return all_metrics;
}

const Metric& metric(std::string_view label) {
  return *std::ranges::find(all_metrics, label, &Metric::label);
}

std::string align_in_words(Align align) {
  if (align == Align::first) return "first (position and heading agree at the first common time)";
  return align == Align::fit ? "fit (least squares over all common positions)" : "none (unchanged)";
}

std::vector<std::string> short_names(const std::vector<std::string>& files) {
  std::vector<std::string> names;
  for (const auto& file : files) names.push_back(std::filesystem::path{file}.stem().string());
  const std::set<std::string> different{names.begin(), names.end()};
  return different.size() == files.size() ? names : files;
}

std::optional<double> improvement(double value, double baseline, double usual) {
  constexpr double by_chance = 0.1;
  if (!(baseline > by_chance * usual)) return std::nullopt;
  return 100.0 * (1.0 - value / baseline);
}

std::string text_of(Metric::Value value, std::string_view label, int decimals) {
  if (!value) return "-";
  const bool is_far_worse = label.ends_with("better by [%]") && *value < -999.0;
  return is_far_worse ? "< -999" : fixed(*value, decimals);
}

Table metrics_table(const EvaluationReport& report) {
  std::vector<std::string> files;
  for (const Evaluation& e : report.evaluations) files.push_back(e.name);
  Table table{{""}, {}, {0}};
  for (const std::string& name : short_names(files)) table.header.push_back(name);
  for (const Metric& metric : all_metrics) {
    std::vector<std::string> cells{std::string{metric.label}};
    for (const Evaluation& e : report.evaluations)
      cells.push_back(text_of(metric.value(e, report.evaluations.at(report.baseline)), metric.label,
                              metric.decimals));
    if (!std::all_of(cells.begin() + 1, cells.end(), [](const auto& cell) { return cell == "-"; }))
      table.rows.push_back(std::move(cells));
  }
  return table;
}

std::string basis_in_words(Against against) {
  switch (against) {
    case Against::reference:
      return "truth.csv";
    case Against::camera:
      return "camera.csv, as there is no truth.csv: each instant against the camera poses taken "
             "after it. The rms is without their noise. Errors of the camera itself are not "
             "visible, nor are errors over less than a second";
    case Against::closed_loop:
      return "its own start: a closed loop, the drive ends where it began. Only the error at the "
             "end is known; errors that cancel along the loop are not visible";
    case Against::nothing:
      break;
  }
  return "nothing: there is no truth.csv, camera.csv does not have a second of usable poses, and "
         "the drive is no closed loop. Errors of position and heading are not known; innovations "
         "show only whether the filter agrees with its sensors";
}

std::string basis_in_words(const EvaluationReport& report) {
  const Evaluation& e = report.evaluations.front();
  if (e.against == Against::reference) return report.reference;
  std::string text = basis_in_words(e.against);
  if (e.against == Against::camera)
    text += "; errors below its noise, " + fixed(1e3 * e.reference_noise, 1) + " mm, are uncertain";
  return text;
}

std::string as_text(const EvaluationReport& report) {
  std::string text = "reference  " + basis_in_words(report) + '\n';
  if (has_reference(report.evaluations.front().against))
    text += "alignment  " + align_in_words(report.align) + '\n';
  if (report.frame == Frame::odom) text += "frame      odom (the pose without jumps)\n";
  if (report.lever_arm) {
    text += "lever arm  " + fixed(report.lever_arm->x, 4) + " m, " + fixed(report.lever_arm->y, 4) +
            " m, " + fixed(degrees * report.lever_arm->yaw, 2) + " deg of the reference point";
    text += report.fitted_windows > 0 ? ", fitted to " + std::to_string(report.fitted_windows) +
                                            " displacements over a second\n"
                                      : ", as given\n";
  }
  return text + '\n' + metrics_table(report).text();
}

Json json_of(const EvaluationReport& report) {
  Json json;
  const Against against = report.evaluations.front().against;
  json["against"] = against_names[static_cast<std::size_t>(against)];
  if (against == Against::closed_loop) json["closed_loop"] = true;
  if (has_reference(against)) {
    json["reference"] = report.reference;
    json["align"] = align_names[static_cast<std::size_t>(report.align)];
  }
  json["frame"] = report.frame == Frame::odom ? "odom" : "map";
  if (report.lever_arm) {
    json["lever_arm"] = {{"x", report.lever_arm->x},
                         {"y", report.lever_arm->y},
                         {"yaw", report.lever_arm->yaw},
                         {"fitted", report.fitted_windows > 0}};
  }
  json["estimates"] = Json::array();
  for (const auto& evaluation : report.evaluations) {
    const Evaluation& baseline = report.evaluations.at(report.baseline);
    json["estimates"].push_back(
        json_of(evaluation, &evaluation == &baseline ? nullptr : &baseline));
  }
  return json;
}

}  // namespace odomd::tools
