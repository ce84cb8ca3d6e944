#include "tools/evaluation/evaluated_drive.hpp"

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>
#include <numeric>
#include <optional>
#include <string>
#include <vector>

#include "tools/diagnostics/output.hpp"
#include "tools/math/se2.hpp"
#include "tools/replay/replay_checks.hpp"

namespace odomd::tools {
namespace {

using Json = nlohmann::ordered_json;

using Value = Metric::Value;

// A column of the table: a metric with a shorter name.
struct Column {
  std::string_view header;
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
    {"NEES", 2, "nees", 1.0, "NEES mean (expected: 3)"},
    {"NIS factor", 2, "nis_factor", 1.0, "NIS factor (expected: 1)"},
    {"path [m]", 1, "path_length", 1.0, "path length [m]"},
}};
constexpr std::size_t per_metre = 0, better_percent = 3;

// One line of the table; a missing figure is a dash.
struct Figures {
  std::string drive;
  std::string estimate;
  std::array<Value, columns.size()> values;
};

// The mean of a column's magnitudes; nothing if one is missing.
Value mean(std::span<const Figures* const> rows, std::size_t column) {
  double sum = 0.0;
  for (const Figures* row : rows) {
    if (!row->values[column]) return std::nullopt;
    sum += std::abs(*row->values[column]);
  }
  return sum / static_cast<double>(rows.size());
}

// One row per drive and estimate, and the means if all drives have the same estimates. The mean
// improvement is computed from the mean cm/m.
std::vector<Figures> all_figures(std::span<const EvaluatedDrive> drives) {
  std::vector<Figures> all;
  const std::vector<std::string> names = names_of(drives.front());
  for (const EvaluatedDrive& drive : drives) {
    const auto& evaluations = drive.report.evaluations;
    for (std::size_t i = 0; i < evaluations.size(); ++i) {
      all.push_back({drive.name, names_of(drive)[i], {}});
      for (std::size_t k = 0; k < columns.size(); ++k)
        all.back().values[k] =
            metric(columns[k].metric).value(evaluations[i], evaluations.at(drive.report.baseline));
    }
  }
  const auto same = [&](const EvaluatedDrive& drive) { return names_of(drive) == names; };
  if (drives.size() < 2 || !std::ranges::all_of(drives, same)) return all;
  std::vector<Figures> means;
  for (std::size_t i = 0; i < names.size(); ++i) {
    std::vector<const Figures*> rows;
    for (std::size_t at = i; at < all.size(); at += names.size()) rows.push_back(&all[at]);
    means.push_back({"mean of " + std::to_string(drives.size()), names[i], {}});
    for (std::size_t k = 0; k < columns.size(); ++k)
      if (k != better_percent) means.back().values[k] = mean(rows, k);
  }
  const std::size_t baseline = drives.front().report.baseline;
  for (std::size_t i = 0; i < means.size(); ++i) {
    const Value its = means[i].values[per_metre], before = means[baseline].values[per_metre];
    if (i != baseline && its && before)
      means[i].values[better_percent] = improvement(*its, *before);
  }
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
      cells.push_back(text_of(row.values[k], columns[k].header, columns[k].decimals));
    table.rows.push_back(std::move(cells));
  }
  return table;
}

std::string_view definition_of(std::string_view label) {
  const auto column = std::ranges::find(columns, label, &Column::header);
  if (column != columns.end()) return metric(column->metric).definition;
  const auto row = std::ranges::find(metrics(), label, &Metric::label);
  return row != metrics().end() ? row->definition : std::string_view{};
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
    const bool tested = statistics.count > 0;
    table.rows.push_back(
        {std::string{estimator::source_names[source]}, std::to_string(count(Verdict::fused)),
         std::to_string(count(Verdict::gated)), std::to_string(count(Verdict::too_old)),
         std::to_string(other), std::to_string(statistics.count),
         tested ? fixed(statistics.nis_per_degree(), 2) : "-",
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
