#include "tools/init/init.hpp"

#include <algorithm>
#include <fstream>
#include <iterator>
#include <set>
#include <stdexcept>

#include <fmt/format.h>
#include <fmt/ranges.h>

#include "can_protocol/sources/open_source.hpp"
#include "daemon/core/config.hpp"
#include "tools/cli/files.hpp"
#include "tools/init/protection.hpp"
#include "tools/sim/car_bus.hpp"

namespace odomd::tools {
namespace {

namespace fs = std::filesystem;

constexpr const char* own_database = "odomd.dbc";

/// An output that must not replace something unasked.
void check_free(const fs::path& file, Overwrite overwrite) {
  if (fs::exists(file) && overwrite == Overwrite::refuse)
    throw std::invalid_argument(
        fmt::format("{}: exists already; name another file with --out, or replace it with --force",
                    file.string()));
  check_writable(file);
}

Traffic traffic_of(const InitOptions& options) {
  if (options.can.empty()) return {};
  const auto interfaces = std::ranges::count_if(options.can, [](const std::string& name) {
    return can::source_kind(name) == can::SourceKind::interface;
  });
  if (interfaces == 0) return read_logs(options.can, options.damage);
  if (options.can.size() > 1)
    throw std::invalid_argument(
        "--can: one interface, or logs; log several interfaces at once with candump -l any");
  return listen(options.can.front(), options.listen_s);
}

std::vector<can::Database> databases_for(const InitOptions& options, const Traffic& traffic) {
  std::vector<can::Database> databases;
  for (const std::string& file : options.databases) databases.push_back(can::read_dbc(file));
  if (!databases.empty()) return databases;
  if (!traffic.empty() && !is_own_bus(traffic))
    throw std::invalid_argument(fmt::format(
        "{}: its identifiers are not those of odomd.dbc, so a database must say what they mean: "
        "give "
        "it with --dbc. The maker of the car or of its control units has it; collections such as "
        "opendbc have many cars",
        traffic.name));
  return {sim::bus_database()};
}

fs::path folder_of(const fs::path& file) {
  return file.has_parent_path() ? file.parent_path() : fs::path(".");
}

/// As the configuration names them: relative to its folder where that is shorter.
std::vector<std::string> named_from(const fs::path& out, const std::vector<std::string>& files) {
  std::vector<std::string> names;
  for (const std::string& file : files)
    names.push_back(fs::path(file).is_absolute() && fs::path(out).is_relative()
                        ? file
                        : fs::proximate(file, folder_of(out)).string());
  return names;
}

/// The interfaces that carry the mapped messages.
std::vector<std::string> sources_of(const Proposal& proposal, const Traffic& traffic,
                                    std::span<const can::Database> databases) {
  const auto came = rhythms(traffic, databases);
  std::set<std::string> carrying;
  for (const auto& choice : proposal.roles) {
    if (!choice) continue;
    if (!choice->bus.empty()) {
      carrying.insert(choice->bus);
      continue;
    }
    const can::Message& message = *choice->candidate.message;
    if (const auto found = came.find(can::frame_key(message.id, message.format));
        found != came.end())
      carrying.insert(found->second.buses.begin(), found->second.buses.end());
  }
  return {carrying.begin(), carrying.end()};
}

void answer(const std::vector<Question>& missing, Car& car, Dialogue* dialogue) {
  if (dialogue != nullptr)
    ask(missing, car, dialogue->in, dialogue->out);
  else if (const auto needed = required(missing); !needed.empty())
    refuse(needed);
}

std::string described(const InitOptions& options, const Traffic& traffic) {
  std::string text = options.databases.empty()
                         ? own_database
                         : fmt::format("{}", fmt::join(options.databases, ", "));
  if (!traffic.empty()) text += " and " + traffic.name;
  return text;
}

/// The configuration as odomd would load it: what is written must load.
diagnostics::Diagnostics checked(const std::string& text, const fs::path& out) {
  diagnostics::Diagnostics warnings;
  daemon::Config config = daemon::parse_config(text, out);
  warnings = config.warnings;
  static_cast<void>(daemon::load_databases(config, warnings));
  return warnings;
}

std::string text_in(const fs::path& file) {
  std::ifstream in(file, std::ios::binary);
  return {std::istreambuf_iterator<char>(in), {}};
}

void write(const fs::path& file, std::string_view text) {
  WholeFile whole(file);
  whole.stream() << text;
  whole.finish();
}

}  // namespace

InitResult init(const InitOptions& options, Dialogue* dialogue) {
  check_free(options.out, options.overwrite);
  const fs::path own = folder_of(options.out) / own_database;
  std::vector<fs::path> inputs{options.databases.begin(), options.databases.end()};
  inputs.insert(inputs.end(), options.can.begin(), options.can.end());
  check_outputs(std::vector<Output>{{"--out", options.out.string()}}, inputs);
  Car car = parse_car(options.car);
  const Traffic traffic = traffic_of(options);
  InitResult result;
  result.databases = databases_for(options, traffic);
  const Proposal named = propose(result.databases, traffic);
  answer(missing_first(car, named), car, dialogue);
  Proposal proposal = named;
  check_behaviour(proposal, car);
  if (const auto missing = missing_last(car, proposal); !missing.empty()) {
    answer(missing, car, dialogue);
    proposal = named;
    check_behaviour(proposal, car);
  }
  auto protections = protections_for(proposal, result.databases, traffic);
  auto sources = sources_of(proposal, traffic, result.databases);
  std::vector<std::string> files = options.databases;
  if (files.empty()) {
    files.push_back(own.string());
    result.wrote_database = !fs::exists(own);
    if (!result.wrote_database && text_in(own) != sim::bus_database_text())
      throw std::invalid_argument(fmt::format(
          "{}: exists already and is another database; name it with --dbc, or move it away",
          own.string()));
  }
  result.draft = {std::move(proposal),    car,
                  std::move(protections), named_from(options.out, files),
                  std::move(sources),     described(options, traffic)};
  const std::string text = as_toml(result.draft);
  try {
    if (result.wrote_database) write(own, sim::bus_database_text());
    append(result.warnings, diagnostics::kind("log_content"), traffic.warnings);
    append(result.warnings, checked(text, options.out));
    write(options.out, text);
  } catch (...) {
    if (result.wrote_database) fs::remove(own);
    throw;
  }
  return result;
}

}  // namespace odomd::tools
