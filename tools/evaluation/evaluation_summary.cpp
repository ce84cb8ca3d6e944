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

using Value = std::optional<double>;

// A column of the table: a metric with a shorter name.
struct Column {
  const char* header;
  int decimals;
  const char* json;  // name of its JSON key
  double si;         // the header's unit in SI units
  const char* metric;
};

// In the order of the paper's conclusion.
constexpr std::array<Column, 8> columns{{
    {"end [cm/m]", 3, "end_error_cm_per_m", 1.0, "end error [cm/m]"},
    {"heading end [deg]", 2, "heading_end", 1.0 / degrees, "heading error at the end [deg]"},
    {"35 ms [mm]", 2, "error_35ms_mean", 1e-3, "35 ms error mean [mm]"},
    {"end better by [%]", 1, "better_percent", 1.0, "end error better by [%]"},
    {"position rms [m]", 4, "position_rms", 1.0, "position rms [m]"},
    {"NEES", 2, "nees", 1.0, "NEES mean (honest: 3)"},
    {"NIS factor", 2, "nis_factor", 1.0, "NIS factor (honest: 1)"},
    {"path [m]", 1, "path_length", 1.0, "path length [m]"},
}};
constexpr std::size_t per_metre = 0, better = 3;

// One line of the table; a missing figure is a dash.
struct Figures {
  std::string drive;
  std::string estimate;
  std::array<Value, columns.size()> values;
};

std::vector<Figures> figures_of(const EvaluatedDrive& drive) {
  const auto& evaluations = drive.report.evaluations;
  const auto names = names_of(drive);
  std::vector<Figures> rows;
  for (std::size_t i = 0; i < evaluations.size(); ++i) {
    rows.push_back({drive.name, names[i], {}});
    const auto metrics = metrics_of(evaluations[i], evaluations.at(drive.report.baseline));
    for (std::size_t k = 0; k < columns.size(); ++k)
      rows.back().values[k] = std::ranges::find(metrics, columns[k].metric, &Metric::label)->value;
  }
  return rows;
}

std::optional<double> mean(const std::vector<std::vector<Figures>>& drives, std::size_t estimate,
                           std::size_t column) {
  double sum = 0.0;
  for (const auto& rows : drives) {
    const Value one = rows[estimate].values[column];
    if (!one) return std::nullopt;
    sum += std::abs(*one);
  }
  return sum / static_cast<double>(drives.size());
}

// Means of the magnitudes over all drives. The improvement is computed from the mean cm/m.
std::vector<Figures> means_of(const std::vector<std::vector<Figures>>& drives,
                              std::size_t baseline) {
  const auto same = [&drives](const auto& rows) {
    return std::ranges::equal(rows, drives.front(), {}, &Figures::estimate, &Figures::estimate);
  };
  if (drives.size() < 2 || !std::ranges::all_of(drives, same)) return {};
  std::vector<Figures> rows;
  for (std::size_t i = 0; i < drives.front().size(); ++i) {
    Figures row{.drive = "mean of " + std::to_string(drives.size()),
                .estimate = drives.front()[i].estimate,
                .values = {}};
    for (std::size_t k = 0; k < columns.size(); ++k)
      if (k != better) row.values[k] = mean(drives, i, k);
    rows.push_back(std::move(row));
  }
  for (std::size_t i = 0; i < rows.size(); ++i) {
    const Value its = rows[i].values[per_metre], before = rows[baseline].values[per_metre];
    if (i != baseline && its && before) rows[i].values[better] = improvement(*its, *before);
  }
  return rows;
}

std::vector<Figures> all_figures(std::span<const EvaluatedDrive> drives) {
  std::vector<std::vector<Figures>> by_drive;
  std::vector<Figures> all;
  for (const EvaluatedDrive& drive : drives) {
    by_drive.push_back(figures_of(drive));
    all.insert(all.end(), by_drive.back().begin(), by_drive.back().end());
  }
  const auto means = means_of(by_drive, drives.front().report.baseline);
  all.insert(all.end(), means.begin(), means.end());
  return all;
}

}  // namespace

Table summary_table(std::span<const EvaluatedDrive> drives) {
  const std::vector<Figures> all = all_figures(drives);
  const bool several = drives.size() > 1;
  std::vector<std::size_t> shown;
  for (std::size_t k = 0; k < columns.size(); ++k)
    if (std::ranges::any_of(all, [k](const Figures& row) { return row.values[k].has_value(); }))
      shown.push_back(k);
  Table table;
  if (several) table.header.emplace_back("drive");
  if (several) table.flush_left.push_back(1);
  table.header.emplace_back("estimate");
  for (const std::size_t k : shown) table.header.emplace_back(columns[k].header);
  for (const Figures& row : all) {
    std::vector<std::string> cells;
    if (several) cells.push_back(row.drive);
    cells.push_back(row.estimate);
    for (const std::size_t k : shown)
      cells.push_back(text_of({columns[k].header, columns[k].decimals, row.values[k]}));
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
    Json one{{"drive", row.drive}, {"estimate", row.estimate}, {"path_length", nullptr}};
    for (std::size_t k = 0; k < columns.size(); ++k) {
      const Value value = row.values[k];
      one[columns[k].json] = value ? Json(*value * columns[k].si) : Json(nullptr);
    }
    json["summary"].push_back(std::move(one));
  }
  return json;
}

}  // namespace odomd::tools
