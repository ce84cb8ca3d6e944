#include "tools/replay/replay_json.hpp"

#include <algorithm>
#include <nlohmann/json.hpp>

#include "daemon/diagnostics/diagnostic.hpp"
#include "tools/diagnostics/output.hpp"
#include "tools/drive_files/pose_csv.hpp"

namespace odomd::tools {
namespace {

// Sources that were found wired or described wrongly, or scattering too much, and for how long [s].
nlohmann::ordered_json wiring_json(const ReplaySummary& summary) {
  auto sources = nlohmann::ordered_json::object();
  const double tick_s = static_cast<double>(summary.last_tick_ns - summary.first_tick_ns) * 1e-9 /
                        static_cast<double>(std::max<std::uint64_t>(summary.ticks, 1));
  for (std::size_t source = 0; source < estimator::source_count; ++source) {
    const std::string name{estimator::source_names[source]};
    for (std::size_t fault = 1; fault < daemon::wiring_names.size(); ++fault)
      if (const std::uint64_t ticks = summary.wired[source][fault]; ticks > 0)
        sources[name][std::string{daemon::wiring_names[fault]}] =
            tick_s * static_cast<double>(ticks);
    if (const std::uint64_t ticks = summary.inconsistent[source]; ticks > 0)
      sources[name]["inconsistent"] = tick_s * static_cast<double>(ticks);
  }
  return sources;
}

}  // namespace

nlohmann::ordered_json innovations_json(const ReplaySummary& summary) {
  auto innovations = nlohmann::ordered_json::object();
  for (std::size_t source = 0; source < summary.innovations.size(); ++source) {
    const daemon::InnovationStatistics& statistics = summary.innovations[source];
    if (statistics.count() == 0) continue;
    innovations[std::string{estimator::source_names[source]}] = {
        {"count", statistics.count()},         {"gated", statistics.gated()},
        {"dimension", statistics.dimension()}, {"mean_nis", statistics.mean_nis()},
        {"inside_95", statistics.inside_95()},
    };
  }
  return innovations;
}

nlohmann::ordered_json noise_json(const ReplaySummary& summary) {
  const auto or_null = [](double value) {
    return value > 0.0 ? nlohmann::ordered_json(value) : nlohmann::ordered_json();
  };
  auto noise = nlohmann::ordered_json::object();
  for (std::size_t source = 0; source < summary.noise.size(); ++source) {
    const estimator::SourceNoise& estimate = summary.noise[source];
    if (!estimate.estimated()) continue;
    noise[std::string{estimator::source_names[source]}] = {
        {"sigma", estimate.stated},
        {"at_rest", or_null(estimate.at_rest)},
        {"moving", or_null(estimate.moving)},
        {"speed_share", or_null(estimate.speed_share)},
    };
  }
  return noise;
}

nlohmann::ordered_json verdicts_json(const ReplaySummary& summary) {
  auto sources = nlohmann::ordered_json::object();
  for (std::size_t source = 0; source < summary.verdicts.size(); ++source) {
    auto verdicts = nlohmann::ordered_json::object();
    for (std::size_t verdict = 0; verdict < estimator::verdict_count; ++verdict) {
      const std::uint64_t count = summary.verdicts[source][verdict];
      if (count > 0) verdicts[std::string{estimator::verdict_names[verdict]}] = count;
    }
    if (!verdicts.empty()) {
      sources[std::string{estimator::source_names[source]}] = std::move(verdicts);
    }
  }
  return sources;
}

nlohmann::ordered_json replay_json(const ReplaySummary& summary, double seconds,
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
