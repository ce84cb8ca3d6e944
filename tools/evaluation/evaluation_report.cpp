#include "tools/evaluation/evaluation_report.hpp"

#include <algorithm>
#include <array>
#include <charconv>
#include <nlohmann/json.hpp>
#include <numbers>
#include <set>
#include <string_view>

#include "tools/cli/csv.hpp"
#include "tools/cli/text.hpp"

namespace odomd::tools {
namespace {

using Json = nlohmann::ordered_json;
constexpr std::array<std::string_view, 4> against_names{"truth", "camera", "closed_loop",
                                                        "nothing"};

constexpr std::array<std::string_view, 3> align_names{"first", "fit", "none"};

double degrees(double radians) {
  return radians * (180.0 / std::numbers::pi);
}

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

Json better(double value, double baseline, double usual = 0.0) {
  const auto percent = improvement(value, baseline, usual);
  return percent ? Json(*percent) : Json(nullptr);
}

Json short_term(const HorizonError& e) {
  return {{"position", spread(e.displacement)}, {"yaw", spread(e.yaw)}, {"samples", e.samples}};
}

void add_reference_figures(const Evaluation& e, Json& json) {
  json["alignment"] = {e.alignment.x, e.alignment.y, e.alignment.yaw};
  json["position"] = spread(e.position);
  if (e.against == Against::camera) json["reference_noise"] = e.reference_noise;
  json["heading"]["rms"] = e.heading.rms;
  json["heading"]["max"] = e.heading.max;
  json["error_35ms"] = e.short_term ? short_term(*e.short_term) : Json(nullptr);
  json["horizons"] = Json::array();
  for (const HorizonError& error : e.horizons) {
    Json one{{"horizon", static_cast<double>(error.horizon_ns) / 1e9}};
    one.update(short_term(error));
    json["horizons"].push_back(std::move(one));
  }
  json["nees"] = nullptr;
  if (e.consistency)
    json["nees"] = {{"mean", e.consistency->nees},
                    {"inside_95", e.consistency->inside_95},
                    {"samples", e.consistency->samples}};
  if (e.velocity_rms) {
    json["velocity_rms"] = {{"vx", e.velocity_rms->vx},
                            {"vy", e.velocity_rms->vy},
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
            {"nis_factor", e.nis_factor ? Json(*e.nis_factor) : Json(nullptr)}};
  if (e.against == Against::nothing) return json;
  json["end_error"] = e.end_error;
  json["end_error_cm_per_m"] = e.end_cm_per_m ? Json(*e.end_cm_per_m) : Json(nullptr);
  json["heading"]["end"] = e.heading_end;
  if (has_reference(e.against)) add_reference_figures(e, json);
  if (baseline == nullptr) return json;
  Json percent{{"against", baseline->name},
               {"end_error", better(e.end_error, baseline->end_error, baseline->position.rms)},
               {"heading_end", better(std::abs(e.heading_end), std::abs(baseline->heading_end),
                                      baseline->heading.rms)}};
  if (has_reference(e.against)) {
    percent["position_rms"] = better(e.position.rms, baseline->position.rms);
    percent["heading_rms"] = better(e.heading.rms, baseline->heading.rms);
    percent["error_35ms_mean"] =
        e.short_term && baseline->short_term
            ? better(e.short_term->displacement.mean, baseline->short_term->displacement.mean)
            : Json(nullptr);
  }
  json["improvement_percent"] = std::move(percent);
  return json;
}

}  // namespace

std::vector<Metric> metrics_of(const Evaluation& e, const Evaluation& baseline) {
  std::vector<Metric> all;
  const auto add = [&all](std::string_view label, int decimals, std::optional<double> value) {
    all.emplace_back(label, decimals, value);
  };
  const auto add_if = [&add](bool known, std::string_view label, int decimals, double value) {
    add(label, decimals, known ? std::optional(value) : std::nullopt);
  };
  const auto add_better = [&](std::string_view label, double value, double before,
                              double usual = 0.0) {
    add(label, 1, &e == &baseline ? std::nullopt : improvement(value, before, usual));
  };
  const bool compared = e.against != Against::nothing, reference = has_reference(e.against);
  const HorizonError short_term = e.short_term.value_or(HorizonError{});

  add("samples", 0, static_cast<double>(e.samples));
  add("time span [s]", 3, static_cast<double>(e.last_ns - e.first_ns) * 1e-9);
  add("path length [m]", 3, e.path_length);
  add_if(compared, "end error [m]", 4, e.end_error);
  add("end error [cm/m]", 3, e.end_cm_per_m);
  add_if(reference, "position rms [m]", 4, e.position.rms);
  add_if(reference, "position max [m]", 4, e.position.max);
  add_if(compared, "heading error at the end [deg]", 3, degrees(e.heading_end));
  add_if(reference, "heading error rms [deg]", 3, degrees(e.heading.rms));
  add_if(reference, "heading error max [deg]", 3, degrees(e.heading.max));
  // The JSON also has their rms and maximum, and further horizons.
  const bool known = e.short_term.has_value();
  add_if(known, "35 ms error mean [mm]", 3, 1e3 * short_term.displacement.mean);
  add_if(known, "35 ms yaw error mean [deg]", 3, degrees(short_term.yaw.mean));
  const auto second = std::ranges::find(e.horizons, 1'000'000'000, &HorizonError::horizon_ns);
  add("1000 ms error mean [mm]", 3,
      second == e.horizons.end() ? std::nullopt : std::optional(1e3 * second->displacement.mean));
  add_if(e.consistency.has_value(), "NEES mean (honest: 3)", 3,
         e.consistency.value_or(Consistency{}).nees);
  add("NIS factor (honest: 1)", 2, e.nis_factor);
  const Motion motion = e.velocity_rms.value_or(Motion{});
  add_if(e.velocity_rms.has_value(), "vx rms [m/s]", 4, motion.vx);
  add_if(e.velocity_rms.has_value(), "vy rms [m/s]", 4, motion.vy);
  add_if(e.velocity_rms.has_value(), "yaw rate rms [deg/s]", 4, degrees(motion.yaw_rate));
  add_better("end error better by [%]", e.end_error, baseline.end_error, baseline.position.rms);
  add_better("position rms better by [%]", e.position.rms, baseline.position.rms);
  add_better("heading end better by [%]", std::abs(e.heading_end), std::abs(baseline.heading_end),
             baseline.heading.rms);
  add_better("35 ms error mean better by [%]", short_term.displacement.mean,
             baseline.short_term.value_or(HorizonError{}).displacement.mean);
  return all;
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

std::string text_of(const Metric& metric) {
  if (!metric.value) return "-";
  const bool is_far_worse = metric.label.ends_with("better by [%]") && *metric.value < -999.0;
  return is_far_worse ? "< -999" : fixed(*metric.value, metric.decimals);
}

std::vector<std::vector<std::string>> report_rows(const EvaluationReport& report) {
  std::vector<std::vector<Metric>> columns;
  for (const Evaluation& e : report.evaluations)
    columns.push_back(metrics_of(e, report.evaluations.at(report.baseline)));
  std::vector<std::vector<std::string>> rows;
  for (std::size_t i = 0; i < columns.front().size(); ++i) {
    const auto is_known = [i](const auto& column) { return column[i].value.has_value(); };
    if (std::ranges::none_of(columns, is_known)) continue;
    rows.push_back({std::string{columns.front()[i].label}});
    for (const auto& column : columns) rows.back().push_back(text_of(column[i]));
  }
  return rows;
}

std::string basis_in_words(Against against) {
  switch (against) {
    case Against::reference:
      return "truth.csv";
    case Against::camera:
      return "camera.csv, as there is no truth.csv: each instant against the camera poses taken "
             "after it. The rms is without their noise. What is wrong with the camera itself is "
             "not seen, nor are errors over less than a second";
    case Against::closed_loop:
      return "its own start: a closed loop, the drive ends where it began. Only the error at the "
             "end is known, and what cancels on the way round is not seen";
    case Against::nothing:
      break;
  }
  return "nothing: there is no truth.csv, camera.csv has not a second of usable poses, and the "
         "drive is no closed loop. Errors of position and heading are not known; innovations show "
         "only whether the filter agrees with its sensors";
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
            " m, " + fixed(degrees(report.lever_arm->yaw), 2) + " deg of the reference point";
    text += report.fitted_windows > 0 ? ", fitted to " + std::to_string(report.fitted_windows) +
                                            " displacements over a second\n"
                                      : ", as given\n";
  }
  text += '\n';

  std::vector<std::string> files;
  for (const auto& e : report.evaluations) files.push_back(e.name);
  Table table{{""}, {}, {0}};
  for (const auto& name : short_names(files)) table.header.push_back(name);
  table.rows = report_rows(report);
  return text + table.text();
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

std::string text_of(const Json& json) {
  return json.dump(2, ' ', false, Json::error_handler_t::replace) + '\n';
}

}  // namespace odomd::tools
