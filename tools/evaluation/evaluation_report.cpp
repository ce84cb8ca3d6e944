#include "tools/evaluation/evaluation_report.hpp"

#include <algorithm>
#include <array>
#include <charconv>
#include <cstdio>
#include <functional>
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

using Cell = std::function<std::optional<std::string>(const Evaluation&)>;

double degrees(double radians) {
  return radians * 180.0 / std::numbers::pi;
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
  if (e.consistency) {
    json["nees"] = {{"mean", e.consistency->nees},
                    {"inside_95", e.consistency->inside_95},
                    {"samples", e.consistency->samples}};
  } else {
    json["nees"] = nullptr;
  }
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

std::string align_name(Align align) {
  switch (align) {
    case Align::first:
      return "first";
    case Align::fit:
      return "fit";
    case Align::none:
      break;
  }
  return "none";
}

std::string align_in_words(Align align) {
  switch (align) {
    case Align::first:
      return "first (position and heading agree at the first common time)";
    case Align::fit:
      return "fit (least squares over all common positions)";
    case Align::none:
      break;
  }
  return "none (unchanged)";
}

std::vector<std::string> short_names(const std::vector<std::string>& files) {
  std::vector<std::string> names;
  names.reserve(files.size());
  for (const auto& file : files) {
    names.push_back(std::filesystem::path{file}.stem().string());
  }
  const std::set<std::string> different{names.begin(), names.end()};
  return different.size() == files.size() ? names : files;
}

std::optional<double> improvement(double value, double baseline, double usual) {
  constexpr double by_chance = 0.1;
  if (!(baseline > by_chance * usual)) return std::nullopt;
  return 100.0 * (1.0 - value / baseline);
}

std::string improvement_text(double percent) {
  return percent < -999.0 ? "< -999" : fixed(percent, 1);
}

std::vector<std::vector<std::string>> report_rows(const EvaluationReport& report) {
  const auto& evaluations = report.evaluations;
  const Evaluation& baseline = evaluations.at(report.baseline);
  std::vector<std::vector<std::string>> all;
  const auto row = [&](const std::string& label, const Cell& cell) {
    std::vector<std::string> cells{label};
    bool any = false;
    for (const auto& e : evaluations) {
      const auto value = cell(e);
      any = any || value.has_value();
      cells.push_back(value.value_or("-"));
    }
    if (any) all.push_back(std::move(cells));
  };
  const auto never = [](const Evaluation&) { return 0.0; };
  const auto against = [&](const std::string& label, const auto& metric, const auto& usual) {
    if (evaluations.size() < 2) return;
    row(label, [&](const Evaluation& e) -> std::optional<std::string> {
      if (&e == &baseline) return std::nullopt;
      const auto percent = improvement(metric(e), metric(baseline), usual(baseline));
      if (!percent) return std::nullopt;
      return improvement_text(*percent);
    });
  };

  row("samples", [](const Evaluation& e) { return std::to_string(e.samples); });
  row("time span [s]", [](const Evaluation& e) {
    return fixed(static_cast<double>(e.last_ns - e.first_ns) * 1e-9, 3);
  });
  row("path length [m]", [](const Evaluation& e) { return fixed(e.path_length, 3); });
  row("end error [m]", [](const Evaluation& e) -> std::optional<std::string> {
    if (e.against == Against::nothing) return std::nullopt;
    return fixed(e.end_error, 4);
  });
  row("end error [cm/m]", [](const Evaluation& e) -> std::optional<std::string> {
    if (!e.end_cm_per_m) return std::nullopt;
    return fixed(*e.end_cm_per_m, 3);
  });
  const auto reference_row = [&](const std::string& label, const auto& metric, int decimals) {
    row(label, [&](const Evaluation& e) -> std::optional<std::string> {
      if (!has_reference(e.against)) return std::nullopt;
      return fixed(metric(e), decimals);
    });
  };
  reference_row(
      "position rms [m]", [](const Evaluation& e) { return e.position.rms; }, 4);
  reference_row(
      "position max [m]", [](const Evaluation& e) { return e.position.max; }, 4);
  row("heading error at the end [deg]", [](const Evaluation& e) -> std::optional<std::string> {
    if (e.against == Against::nothing) return std::nullopt;
    return fixed(degrees(e.heading_end), 3);
  });
  reference_row(
      "heading error rms [deg]", [](const Evaluation& e) { return degrees(e.heading.rms); }, 3);
  reference_row(
      "heading error max [deg]", [](const Evaluation& e) { return degrees(e.heading.max); }, 3);
  const auto short_row = [&](const std::string& label, const auto& metric) {
    row(label, [&](const Evaluation& e) -> std::optional<std::string> {
      if (!e.short_term) return std::nullopt;
      return fixed(metric(*e.short_term), 3);
    });
  };
  short_row("35 ms error mean [mm]",
            [](const HorizonError& s) { return 1e3 * s.displacement.mean; });
  short_row("35 ms error rms [mm]", [](const HorizonError& s) { return 1e3 * s.displacement.rms; });
  short_row("35 ms error max [mm]", [](const HorizonError& s) { return 1e3 * s.displacement.max; });
  short_row("35 ms yaw error mean [deg]",
            [](const HorizonError& s) { return degrees(s.yaw.mean); });
  short_row("35 ms yaw error rms [deg]", [](const HorizonError& s) { return degrees(s.yaw.rms); });
  short_row("35 ms yaw error max [deg]", [](const HorizonError& s) { return degrees(s.yaw.max); });
  for (const std::int64_t horizon_ns : {5'000'000LL, 100'000'000LL, 1'000'000'000LL}) {
    row(fixed(static_cast<double>(horizon_ns) * 1e-6, 0) + " ms error mean [mm]",
        [&](const Evaluation& e) -> std::optional<std::string> {
          const auto at = std::ranges::find(e.horizons, horizon_ns, &HorizonError::horizon_ns);
          if (at == e.horizons.end()) return std::nullopt;
          return fixed(1e3 * at->displacement.mean, 3);
        });
  }
  row("NEES mean (honest: 3)", [](const Evaluation& e) -> std::optional<std::string> {
    if (!e.consistency) return std::nullopt;
    return fixed(e.consistency->nees, 3);
  });
  row("NIS factor (honest: 1)", [](const Evaluation& e) -> std::optional<std::string> {
    if (!e.nis_factor) return std::nullopt;
    return fixed(*e.nis_factor, 2);
  });
  const auto motion_row = [&](const std::string& label, const auto& metric) {
    row(label, [&](const Evaluation& e) -> std::optional<std::string> {
      if (!e.velocity_rms) return std::nullopt;
      return fixed(metric(*e.velocity_rms), 4);
    });
  };
  motion_row("vx rms [m/s]", [](const Motion& m) { return m.vx; });
  motion_row("vy rms [m/s]", [](const Motion& m) { return m.vy; });
  motion_row("yaw rate rms [deg/s]", [](const Motion& m) { return degrees(m.yaw_rate); });
  const auto position_rms = [](const Evaluation& e) { return e.position.rms; };
  against(
      "end error better by [%]", [](const Evaluation& e) { return e.end_error; }, position_rms);
  against("position rms better by [%]", position_rms, never);
  against(
      "heading end better by [%]", [](const Evaluation& e) { return std::abs(e.heading_end); },
      [](const Evaluation& e) { return e.heading.rms; });
  against(
      "35 ms error mean better by [%]",
      [](const Evaluation& e) { return e.short_term ? e.short_term->displacement.mean : 0.0; },
      never);
  return all;
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
  files.reserve(report.evaluations.size());
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
    json["align"] = align_name(report.align);
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
