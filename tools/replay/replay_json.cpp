// The result of a replay as JSON.
#include "tools/replay/replay_checks.hpp"

#include <algorithm>
#include <nlohmann/json.hpp>
#include <utility>

#include "daemon/diagnostics/diagnostic.hpp"
#include "tools/diagnostics/output.hpp"
#include "tools/drive_files/pose_csv.hpp"

namespace odomd::tools {
namespace {

using Json = nlohmann::ordered_json;

/// An object with the values of all sources that have a value.
template <typename ValueOf>
Json by_source(const ValueOf& value_of) {
  Json sources = Json::object();
  for (std::size_t source = 0; source < estimator::source_count; ++source)
    if (Json value = value_of(source); !value.empty())
      sources[std::string{estimator::source_names[source]}] = std::move(value);
  return sources;
}

// For how long [s] each source had a wiring fault or was inconsistent.
Json wiring_json(const ReplaySummary& summary) {
  const double tick_s = static_cast<double>(summary.last_tick_ns - summary.first_tick_ns) * 1e-9 /
                        static_cast<double>(std::max<std::uint64_t>(summary.ticks, 1));
  return by_source([&](std::size_t source) {
    Json faults;
    for (std::size_t fault = 1; fault < daemon::wiring_names.size(); ++fault)
      if (const std::uint64_t ticks = summary.wired[source][fault]; ticks > 0)
        faults[std::string{daemon::wiring_names[fault]}] = tick_s * static_cast<double>(ticks);
    if (const std::uint64_t ticks = summary.inconsistent[source]; ticks > 0)
      faults["inconsistent"] = tick_s * static_cast<double>(ticks);
    return faults;
  });
}

/// The stated sigma and the filter's estimates at the end (null: none), for each source that has an
/// estimate.
Json noise_json(const ReplaySummary& summary) {
  const auto or_null = [](double value) { return value > 0.0 ? Json(value) : Json(); };
  return by_source([&](std::size_t source) -> Json {
    const estimator::SourceNoise& estimate = summary.noise[source];
    if (!estimate.estimated()) return {};
    return {{"sigma", estimate.stated},
            {"at_rest", or_null(estimate.at_rest)},
            {"moving", or_null(estimate.moving)},
            {"speed_share", or_null(estimate.speed_share)}};
  });
}

}  // namespace

Json innovations_json(const ReplaySummary& summary) {
  return by_source([&](std::size_t source) -> Json {
    const daemon::InnovationStatistics& statistics = summary.innovations[source];
    if (statistics.count == 0) return {};
    return {{"count", statistics.count},
            {"gated", statistics.gated},
            {"dimension", statistics.dimension},
            {"mean_nis", statistics.mean_nis()},
            {"inside_95", statistics.inside_95()}};
  });
}

Json verdicts_json(const ReplaySummary& summary) {
  return by_source([&](std::size_t source) {
    Json verdicts;
    for (std::size_t verdict = 0; verdict < estimator::verdict_count; ++verdict)
      if (const std::uint64_t count = summary.verdicts[source][verdict]; count > 0)
        verdicts[std::string{estimator::verdict_names[verdict]}] = count;
    return verdicts;
  });
}

Json replay_json(const ReplaySummary& summary, double seconds,
                 const diagnostics::Diagnostics& warnings) {
  return {
      {"frames", summary.frames},
      {"camera_poses", summary.cameras},
      {"ticks", summary.ticks},
      {"poses", summary.poses},
      {"drive_s", static_cast<double>(summary.last_tick_ns - summary.first_tick_ns) * 1e-9},
      {"replay_s", seconds},
      {"last_mode", mode_name(summary.last_mode)},
      {"verdicts", verdicts_json(summary)},
      {"innovations", innovations_json(summary)},
      {"noise", noise_json(summary)},
      {"wiring", wiring_json(summary)},
      {"warnings", texts_of(warnings)},
      {"diagnostics", as_json(warnings)},
  };
}

}  // namespace odomd::tools
