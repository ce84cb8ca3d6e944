// load_config(): reads the keys of the table into the configuration. Also parses the values that it
// shares with the command line: the model and a pose.
#include "daemon/core/config.hpp"

#include <algorithm>
#include <charconv>
#include <cmath>
#include <utility>
#include <variant>

#include <fmt/format.h>
#include <fmt/ranges.h>

#include "daemon/core/config_keys.hpp"
#include "daemon/core/config_sections.hpp"
#include "estimator/integrity/admission.hpp"

namespace odomd::daemon {
namespace {

/// Reads a key into the member that it sets.
struct Reader {
  TableReader& table;
  const ConfigKey& key;
  Config& config;

  void operator()(const Choice& choice) const {
    if (const auto name = table.read_choice(key.name, choice.names)) choice.set(config, *name);
  }
  template <typename Value>
  void operator()(Member<Value> member) const {
    read(member(config));
  }

  void read(auto& numbers) const { table.read(key.name, numbers, key.range); }
  template <typename Value>
  void read(std::optional<Value>& value) const {
    if (table.has(key.name)) read(value.emplace());
  }
  void read(int& value) const {
    table.read(key.name, value, static_cast<int>(key.range.lowest),
               static_cast<int>(key.range.highest));
  }
  void read(std::int64_t& value) const { table.read_seconds(key.name, value, key.range); }
  void read(std::uint32_t& value) const { table.read_mode(key.name, value); }
  void read(std::string& value) const { table.read(key.name, value); }
  void read(std::filesystem::path& value) const { table.read(key.name, value); }
  void read(estimator::Pose2& value) const {
    std::array<double, 3> pose{};
    read(pose);
    value = {pose[0], pose[1], pose[2]};
  }
  void read(estimator::Model& value) const {
    if (!table.has(key.name)) return;
    std::string name;
    table.read(key.name, name);
    try {
      value = parse_model(name);
    } catch (const std::invalid_argument& error) {
      table.fail(key.name, error.what());
    }
  }
};

void read_table(TableReader table, std::span<const ConfigKey> keys, Config& config) {
  const std::string_view name = keys.front().table;
  if (name == "can") read_buses(table, config.can);
  if (name == "initial") table.require("pose");
  for (const ConfigKey& key : keys) {
    std::visit(Reader{table, key, config}, key.member);
    if (key.problem == nullptr) continue;
    if (const auto problem = key.problem(config); !problem.empty())
      table.fail(key.name, std::string(problem));
  }
  if (name == "can") read_messages(table, config.can);
  table.finish();
  // All numbers or none: a mixture of two cars would give wrong poses.
  if (name == "vehicle")
    for (const ConfigKey& key : keys.first(numbers_of_a_car))
      if (!table.has(key.name))
        table.fail(key.name, "is missing; give all keys of [vehicle], or leave the table out");
}

}  // namespace

Config load_config(const std::filesystem::path& file) {
  return parse_config(read_toml_file(file), file);
}

Config parse_config(std::string text, const std::filesystem::path& file) {
  Config config;
  config.file = file;
  config.text = std::move(text);
  const toml::table parsed = parse_toml(config.text, file);
  TableReader root(parsed, "", file);

  const auto keys = config_keys();
  for (auto at = keys.begin(); at != keys.end();) {
    const auto end = std::ranges::find_if(
        at, keys.end(), [at](const ConfigKey& key) { return key.table != at->table; });
    if (at->table == "can") root.require("can", "; name the database and the signals in [can]");
    if (auto table = root.table(at->table, fmt::format("[{}]", at->table)))
      read_table(std::move(*table), {at, end}, config);
    at = end;
  }
  root.finish();
  config.camera.configured = parsed.contains("camera");
  if (!parsed.contains("vehicle"))
    config.warnings.push_back(found(
        diagnostics::kind("reference_car"), file.string(),
        fmt::format("no [vehicle]: using the reference car (1:10, {} kg)", config.vehicle.mass)));
  return config;
}

void place_sockets(Config& config, const std::filesystem::path& directory) {
  const auto place = [](SocketConfig& socket, const std::filesystem::path& path) {
    if (socket.path.empty()) socket.path = path;
  };
  place(config.camera.socket, directory / "camera.sock");
  place(config.status, directory / "status.sock");
  place(config.record, config.status.path.parent_path() / "record.sock");
  const std::uint32_t mode = config.shm.mode;
  config.record.mode = mode | (mode & 0444U) >> 1U;  // connecting needs write permission
  config.record.group = config.shm.group;
}

const can::SignalBinding* binding_of(const Config& config, estimator::Source source) {
  const auto found = std::ranges::find(config.can.bindings, estimator::index_of(source),
                                       &can::SignalBinding::channel);
  return found == config.can.bindings.end() ? nullptr : &*found;
}

estimator::Model parse_model(std::string_view name) {
  const auto* const found = std::ranges::find(estimator::model_names, name);
  if (found == estimator::model_names.end())
    throw std::invalid_argument(
        fmt::format("\"{}\" is not a model of this version; the models are: {}", name,
                    fmt::join(estimator::model_names, ", ")));
  return static_cast<estimator::Model>(found - estimator::model_names.begin());
}

std::string_view name_of(estimator::Model model) {
  return estimator::model_names[static_cast<std::size_t>(model)];
}

estimator::Pose2 parse_pose(std::string_view text) {
  std::array<double, 3> pose{};
  const char* at = text.data();
  const char* const end = text.data() + text.size();
  for (std::size_t i = 0; i < pose.size(); ++i) {
    const auto [next, error] = std::from_chars(at, end, pose[i]);
    const bool last = i + 1 == pose.size();
    const bool ends_well = last ? next == end : (next != end && *next == ',');
    if (error != std::errc{} || !std::isfinite(pose[i]) || !ends_well)
      throw std::invalid_argument(fmt::format(
          "\"{}\" is not a pose; write x,y,yaw in metres and radians, as 1.5,-0.2,3.14", text));
    at = next + (last ? 0 : 1);
  }
  const estimator::Pose2 result{pose[0], pose[1], pose[2]};
  if (!estimator::is_possible(result))
    throw std::invalid_argument(fmt::format("\"{}\" {}", text, pose_too_far));
  return result;
}

}  // namespace odomd::daemon
