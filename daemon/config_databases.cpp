// load_databases(): the configuration held against the databases that it names.
#include <algorithm>

#include <fmt/format.h>

#include "can_protocol/decoder.hpp"
#include "can_protocol/nearest_name.hpp"
#include "can_protocol/open_source.hpp"
#include "daemon/config.hpp"

namespace odomd::daemon {
namespace {

using estimator::Source;

constexpr std::int64_t default_timeout_ns = 100'000'000;
constexpr std::int64_t cycles_until_overdue = 3;

bool is_mapped(const Config& config, Source source) {
  return config.can.signals[static_cast<std::size_t>(source)].configured;
}

/// What a model cannot do without, and what it does without it.
void check_roles(const Config& config, std::vector<std::string>& warnings) {
  constexpr Source speeds[] = {Source::wheel_front_left, Source::wheel_front_right,
                               Source::wheel_rear_left,  Source::wheel_rear_right,
                               Source::wheel_rear,       Source::motor};
  if (std::ranges::none_of(speeds, [&](Source source) { return is_mapped(config, source); }))
    throw ConfigError(fmt::format(
        "{}: [can.signals]: no speed is mapped; map wheel_rear, the four wheels or motor",
        config.file.string()));
  const auto warn = [&](Source source, std::string_view without) {
    if (!is_mapped(config, source))
      warnings.push_back(
          fmt::format("{}: [can.signals]: {} is not mapped: {}", config.file.string(),
                      estimator::source_names[static_cast<std::size_t>(source)], without));
  };
  warn(Source::steering, "the car is taken to steer straight ahead");
  if (config.model == estimator::Model::paper)
    warn(Source::yaw_rate, "the filter takes it to measure 0");
}

/// A value that is taken from one bus alone never comes when that bus is not listened to. What
/// buses a log has is seen when it is read.
void check_buses(const Config& config) {
  const auto& sources = config.can.sources;
  const auto is_interface = [](const std::string& source) {
    return can::source_kind(source) == can::SourceKind::interface;
  };
  if (sources.empty() || !std::ranges::all_of(sources, is_interface)) return;
  for (const auto& binding : config.can.bindings)
    if (!binding.bus.empty() && std::ranges::find(sources, binding.bus) == sources.end())
      throw ConfigError(fmt::format("{}: signal '{}': bus '{}' is no source{}",
                                    config.file.string(), binding.role, binding.bus,
                                    nearest_hint(binding.bus, sources)));
}

}  // namespace

std::vector<std::string> expected_buses(const Config& config) {
  std::vector<std::string> buses;
  for (const auto& binding : config.can.bindings)
    if (!binding.bus.empty() && std::ranges::find(buses, binding.bus) == buses.end())
      buses.push_back(binding.bus);
  if (buses.size() > can::max_buses)
    throw ConfigError(fmt::format("{}: [can.signals]: names {} buses; {} is the most",
                                  config.file.string(), buses.size(), can::max_buses));
  return buses;
}

std::vector<can::Database> load_databases(Config& config, std::vector<std::string>& warnings) {
  std::vector<can::Database> databases;
  for (const auto& file : config.can.dbc) {
    databases.push_back(can::read_dbc(file));
    for (const auto& warning : databases.back().warnings)
      warnings.push_back(can::describe(databases.back(), warning));
  }
  check_roles(config, warnings);
  check_buses(config);

  const auto buses = expected_buses(config);
  try {
    const can::Decoder decoder(databases, config.can.bindings, config.can.protections, buses);
    for (const auto& message : decoder.messages()) {
      const std::int64_t timeout_ns = message.cycle_time_ns > 0
                                          ? cycles_until_overdue * message.cycle_time_ns
                                          : default_timeout_ns;
      for (const auto channel : message.channels)
        if (auto& signal = config.can.signals[channel]; signal.timeout_ns == 0)
          signal.timeout_ns = timeout_ns;
    }
  } catch (const std::invalid_argument& error) {
    throw ConfigError(fmt::format("{}: {}", config.file.string(), error.what()));
  }
  return databases;
}

estimator::FilterSettings filter_settings(const Config& config) {
  estimator::FilterSettings settings;
  settings.vehicle = config.vehicle;
  settings.period_s = static_cast<double>(config.realtime.period_ns) * 1e-9;
  settings.paper = config.paper_noise;
  settings.imu_position = config.imu_position;
  settings.window_s = config.window_s;
  for (std::size_t i = 0; i < estimator::source_count; ++i)
    settings.sigma[i] = config.can.signals[i].sigma;
  settings.camera_max_latency_s = config.camera.max_latency_s;
  return settings;
}

}  // namespace odomd::daemon
