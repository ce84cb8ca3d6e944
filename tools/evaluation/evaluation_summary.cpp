#include "tools/evaluation/evaluation_summary.hpp"

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>
#include <numbers>
#include <numeric>
#include <optional>
#include <string>
#include <vector>

#include "tools/diagnostics/output.hpp"
#include "tools/replay/replay_json.hpp"

namespace odomd::tools {
namespace {

using Json = nlohmann::ordered_json;

constexpr double degrees = 180.0 / std::numbers::pi;

// One line of the table; a missing figure is a dash.
struct Figures {
  std::string drive;
  std::string estimate;
  std::optional<double> path;  // m
  std::optional<double> cm_per_m;
  std::optional<double> heading_end;   // deg
  std::optional<double> short_term;    // mm
  std::optional<double> better;        // %, of the end error
  std::optional<double> position_rms;  // m
  std::optional<double> nees;
  std::optional<double> nis_factor;
};

struct Column {
  const char* header;
  std::optional<double> Figures::*value;
  int decimals;
};

// In the order of the paper's conclusion.
constexpr std::array<Column, 8> columns{{
    {"end [cm/m]", &Figures::cm_per_m, 3},
    {"heading end [deg]", &Figures::heading_end, 2},
    {"35 ms [mm]", &Figures::short_term, 2},
    {"end better by [%]", &Figures::better, 1},
    {"position rms [m]", &Figures::position_rms, 4},
    {"NEES", &Figures::nees, 2},
    {"NIS factor", &Figures::nis_factor, 2},
    {"path [m]", &Figures::path, 1},
}};

std::vector<Figures> figures_of(const EvaluatedDrive& drive) {
  const auto& evaluations = drive.report.evaluations;
  const Evaluation& baseline = evaluations.at(drive.report.baseline);
  const auto names = names_of(drive);
  std::vector<Figures> rows;
  for (std::size_t i = 0; i < evaluations.size(); ++i) {
    const Evaluation& e = evaluations[i];
    Figures row{.drive = drive.name, .estimate = names[i], .path = e.path_length};
    row.cm_per_m = e.end_cm_per_m;
    if (e.against != Against::nothing) row.heading_end = e.heading_end * degrees;
    row.nis_factor = e.nis_factor;
    if (e.short_term) row.short_term = 1e3 * e.short_term->displacement.mean;
    if (&e != &baseline)
      row.better = improvement(e.end_error, baseline.end_error, baseline.position.rms);
    if (has_reference(e.against)) row.position_rms = e.position.rms;
    if (e.consistency) row.nees = e.consistency->nees;
    rows.push_back(std::move(row));
  }
  return rows;
}

std::optional<double> mean(const std::vector<std::vector<Figures>>& drives, std::size_t estimate,
                           std::optional<double> Figures::*value) {
  double sum = 0.0;
  for (const auto& rows : drives) {
    const auto one = rows[estimate].*value;
    if (!one) return std::nullopt;
    sum += std::abs(*one);
  }
  return sum / static_cast<double>(drives.size());
}

// The means over all drives, of headings the mean magnitude. The improvement is that of the mean
// cm/m.
std::vector<Figures> means_of(const std::vector<std::vector<Figures>>& drives,
                              std::size_t baseline) {
  const auto same = [&drives](const auto& rows) {
    return std::ranges::equal(rows, drives.front(), {}, &Figures::estimate, &Figures::estimate);
  };
  if (drives.size() < 2 || !std::ranges::all_of(drives, same)) return {};
  std::vector<Figures> rows;
  for (std::size_t i = 0; i < drives.front().size(); ++i) {
    Figures row{.drive = "mean of " + std::to_string(drives.size()),
                .estimate = drives.front()[i].estimate};
    for (const Column& column : columns) {
      if (column.value != &Figures::better) row.*column.value = mean(drives, i, column.value);
    }
    rows.push_back(std::move(row));
  }
  for (std::size_t i = 0; i < rows.size(); ++i) {
    if (i == baseline || !rows[i].cm_per_m || !rows[baseline].cm_per_m) continue;
    rows[i].better = improvement(*rows[i].cm_per_m, *rows[baseline].cm_per_m);
  }
  return rows;
}

std::vector<Figures> all_figures(std::span<const EvaluatedDrive> drives) {
  std::vector<std::vector<Figures>> by_drive;
  for (const EvaluatedDrive& drive : drives) by_drive.push_back(figures_of(drive));
  std::vector<Figures> all;
  for (const auto& rows : by_drive) all.insert(all.end(), rows.begin(), rows.end());
  const auto means = means_of(by_drive, drives.front().report.baseline);
  all.insert(all.end(), means.begin(), means.end());
  return all;
}

}  // namespace

Table summary_table(std::span<const EvaluatedDrive> drives) {
  const std::vector<Figures> all = all_figures(drives);
  const bool several = drives.size() > 1;
  std::vector<Column> shown;
  std::ranges::copy_if(columns, std::back_inserter(shown), [&all](const Column& column) {
    return std::ranges::any_of(all,
                               [&](const Figures& row) { return (row.*column.value).has_value(); });
  });
  Table table;
  if (several) table.header.emplace_back("drive");
  if (several) table.flush_left.push_back(1);
  table.header.emplace_back("estimate");
  for (const Column& column : shown) table.header.emplace_back(column.header);
  for (const Figures& row : all) {
    std::vector<std::string> cells;
    if (several) cells.push_back(row.drive);
    cells.push_back(row.estimate);
    for (const Column& column : shown) {
      const auto value = row.*column.value;
      cells.push_back(!value                             ? "-"
                      : column.value == &Figures::better ? improvement_text(*value)
                                                         : fixed(*value, column.decimals));
    }
    table.rows.push_back(std::move(cells));
  }
  return table;
}

Table source_table(const ReplaySummary& summary) {
  using estimator::Verdict;
  Table table{
      {"source", "fused", "gated", "late", "other", "tested", "NIS / expected", "inside 95 % [%]"},
      {},
      {0}};
  for (std::size_t source = 0; source < estimator::source_count; ++source) {
    const auto& verdicts = summary.verdicts[source];
    const auto all = std::accumulate(verdicts.begin(), verdicts.end(), std::uint64_t{0});
    if (all == 0) continue;
    const auto count = [&verdicts](Verdict verdict) {
      return verdicts[static_cast<std::size_t>(verdict)];
    };
    const auto other =
        all - count(Verdict::fused) - count(Verdict::gated) - count(Verdict::too_old);
    const daemon::InnovationStatistics& statistics = summary.innovations[source];
    const bool tested = statistics.count() > 0;
    table.rows.push_back(
        {std::string{estimator::source_names[source]}, std::to_string(count(Verdict::fused)),
         std::to_string(count(Verdict::gated)), std::to_string(count(Verdict::too_old)),
         std::to_string(other), std::to_string(statistics.count()),
         tested ? fixed(statistics.mean_nis() / statistics.dimension(), 2) : "-",
         tested ? fixed(100.0 * statistics.inside_95(), 1) : "-"});
  }
  return table;
}

Json summary_json(std::span<const EvaluatedDrive> drives) {
  Json json{{"drives", Json::array()}};
  for (const EvaluatedDrive& drive : drives) {
    Json one{{"drive", drive.name}};
    one.update(json_of(drive.report));
    for (std::size_t i = 0; i < drive.replays.size(); ++i) {
      one["estimates"][i]["innovations"] = innovations_json(drive.replays[i].summary);
      one["estimates"][i]["verdicts"] = verdicts_json(drive.replays[i].summary);
    }
    one["warnings"] = texts_of(drive.warnings);
    one["diagnostics"] = as_json(drive.warnings);
    json["drives"].push_back(std::move(one));
  }
  json["summary"] = Json::array();
  for (const Figures& row : all_figures(drives)) {
    const auto value = [](std::optional<double> number, double factor) {
      return number ? Json(*number * factor) : Json(nullptr);
    };
    json["summary"].push_back({{"drive", row.drive},
                               {"estimate", row.estimate},
                               {"path_length", value(row.path, 1.0)},
                               {"end_error_cm_per_m", value(row.cm_per_m, 1.0)},
                               {"heading_end", value(row.heading_end, 1.0 / degrees)},
                               {"error_35ms_mean", value(row.short_term, 1e-3)},
                               {"better_percent", value(row.better, 1.0)},
                               {"position_rms", value(row.position_rms, 1.0)},
                               {"nees", value(row.nees, 1.0)},
                               {"nis_factor", value(row.nis_factor, 1.0)}});
  }
  return json;
}

}  // namespace odomd::tools
