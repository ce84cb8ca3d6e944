#include "tools/init/init.hpp"

#include <algorithm>
#include <array>
#include <cstdint>
#include <set>

#include <fmt/format.h>
#include <fmt/ranges.h>

#include "can_protocol/decode/decoder.hpp"
#include "can_protocol/sources/open_source.hpp"
#include "daemon/core/config.hpp"
#include "tools/cli/files.hpp"
#include "tools/cli/text.hpp"
#include "tools/sim/car_bus.hpp"

namespace odomd::tools {
namespace {

namespace fs = std::filesystem;

bool is_own(const can::Message& message) {
  const can::Message* own = can::find_message(sim::bus_database(), message.name);
  if (own == nullptr || own->id != message.id || own->format != message.format) return false;
  const can::E2eBinding binding = sim::bus_protection(message);
  return can::find_signal(message, binding.crc_signal) != nullptr &&
         can::find_signal(message, binding.counter_signal) != nullptr;
}

/// Whether most frames of a message have the checksum and the counter of odomd.dbc.
bool is_protected(const can::Message& message, const Traffic& traffic) {
  can::SignalBinding binding;
  binding.role = binding.message = message.name;
  binding.signals = {message.signals.back().name};
  const std::array bindings{binding};
  const std::array protections{sim::bus_protection(message)};
  can::Decoder decoder(std::span(&sim::bus_database(), 1), bindings, protections, traffic.buses);
  std::array<can::Sample, can::max_samples_per_frame> samples{};
  std::uint64_t passed = 0, frames = 0;
  for (const can::Frame& frame : traffic.frames) {
    const can::DecodeResult result = decoder.decode(frame, samples);
    if (result.message < 0) continue;
    ++frames;
    if (result.verdict == can::FrameVerdict::decoded) ++passed;
  }
  return 2 * passed > frames;
}

// Protection for those messages of the proposal that odomd.dbc defines. If there is traffic, their
// checksums in it must be correct; otherwise the roles of the message get a warning.
std::vector<can::E2eBinding> protections_for(Proposal& proposal,
                                             std::span<const can::Database> databases,
                                             const Traffic& traffic) {
  std::vector<can::E2eBinding> protections;
  for (const can::Database& database : databases)
    for (const can::Message& message : database.messages) {
      std::vector<Choice*> users;
      for (auto& choice : proposal.roles)
        if (choice && choice->candidate.message == &message) users.push_back(&*choice);
      if (users.empty() || !is_own(message)) continue;
      if (traffic.empty() || is_protected(message, traffic)) {
        protections.push_back(sim::bus_protection(message));
        continue;
      }
      for (Choice* user : users)
        user->warnings.push_back("the checksums of " + message.name +
                                 " are wrong in the log: it is not protected");
    }
  return protections;
}

// Whether most messages of odomd.dbc arrive in full length.
bool is_own_bus(const Traffic& traffic) {
  const auto& messages = sim::bus_database().messages;
  const auto came = std::ranges::count_if(messages, [&](const can::Message& message) {
    return std::ranges::any_of(traffic.frames, [&](const can::Frame& frame) {
      return can::frame_key(frame) == can::frame_key(message.id, message.format) &&
             frame.length >= message.length;
    });
  });
  return 2 * static_cast<std::size_t>(came) > messages.size();
}

/// Refuses to replace an existing file without --force.
void check_free(const fs::path& file, Overwrite overwrite) {
  if (fs::exists(file) && overwrite == Overwrite::refuse)
    refuse("{}: exists already; name another file with --out, or replace it with --force",
           file.string());
  check_writable(file);
}

Traffic traffic_of(const InitOptions& options) {
  if (options.can.empty()) return {};
  const auto interfaces = std::ranges::count_if(options.can, [](const std::string& name) {
    return can::source_kind(name) == can::SourceKind::interface;
  });
  if (interfaces == 0) return read_logs(options.can, options.damage);
  if (options.can.size() > 1)
    refuse("--can: one interface, or logs; log several interfaces at once with candump -l any");
  return listen(options.can.front(), options.listen_s);
}

/// A database that is written next to the configuration: "vesc-23.dbc".
struct MadeDatabase {
  std::string name, text;
};

/// The database of the VESC, or odomd.dbc if no database is given.
std::optional<MadeDatabase> made_database(const InitOptions& options, const Traffic& traffic) {
  if (options.vesc)
    return MadeDatabase{fmt::format("vesc-{}.dbc", *options.vesc), vesc_database(*options.vesc)};
  if (!options.databases.empty()) return std::nullopt;
  if (!traffic.empty() && !is_own_bus(traffic))
    refuse(
        "{}: its identifiers are not those of odomd.dbc, so a database must say what they mean: "
        "give it with --dbc, or name a motor controller with --vesc. The maker of the "
        "car or of its control units has it; collections such as opendbc have many cars",
        traffic.name);
  return MadeDatabase{"odomd.dbc", std::string(sim::bus_database_text())};
}

fs::path folder_of(const fs::path& file) {
  return file.has_parent_path() ? file.parent_path() : fs::path(".");
}

/// The names of files as written in `out`: relative to its folder. Absolute names are kept if `out`
/// is relative.
std::vector<std::string> named_from(const fs::path& out, const std::vector<std::string>& files) {
  std::vector<std::string> names;
  for (const std::string& file : files)
    names.push_back(fs::path(file).is_absolute() && fs::path(out).is_relative()
                        ? file
                        : fs::proximate(file, folder_of(out)).string());
  return names;
}

/// The interfaces that carry the mapped messages.
std::vector<std::string> sources_of(const Proposal& proposal) {
  std::set<std::string> carrying;
  for (const auto& choice : proposal.roles)
    if (choice) carrying.insert(choice->buses.begin(), choice->buses.end());
  return {carrying.begin(), carrying.end()};
}

/// Loads the configuration as odomd does, so that only a valid one is written.
diagnostics::Diagnostics checked(const std::string& text, const fs::path& out) {
  daemon::Config config = daemon::parse_config(text, out);
  diagnostics::Diagnostics warnings = config.warnings;
  static_cast<void>(daemon::load_databases(config, warnings));
  return warnings;
}

}  // namespace

InitResult init(const InitOptions& options) {
  check_free(options.out, options.overwrite);
  std::vector<fs::path> inputs{options.databases.begin(), options.databases.end()};
  inputs.insert(inputs.end(), options.can.begin(), options.can.end());
  check_outputs(std::vector<Output>{{"--out", options.out.string()}}, inputs);
  Car car = parse_car(options.car);
  const Traffic traffic = traffic_of(options);
  if (options.vesc && !traffic.empty()) require_frames(*options.vesc, traffic);
  InitResult result;
  std::vector<std::string> files = options.databases;
  for (const std::string& file : files) result.databases.push_back(can::read_dbc(file));
  std::vector<std::string> names = files;
  const auto made = made_database(options, traffic);
  fs::path made_file;
  if (made) {
    result.databases.push_back(can::parse_dbc(made->text, made->name));
    made_file = folder_of(options.out) / made->name;
    files.push_back(made_file.string());
    names.push_back(made->name);
    if (!fs::exists(made_file))
      result.wrote_database = made->name;
    else if (read_whole(made_file) != made->text)
      refuse("{}: exists already and is another database; name it with --dbc, or move it away",
             made_file.string());
  }
  Proposal proposal = propose(result.databases, traffic);
  if (options.vesc) settle_motor(proposal, *options.vesc, car);
  check_behaviour(proposal, car);
  require_numbers(car, proposal);
  auto protections = protections_for(proposal, result.databases, traffic);
  auto sources = sources_of(proposal);
  result.draft = {
      std::move(proposal),
      car,
      std::move(protections),
      named_from(options.out, files),
      std::move(sources),
      fmt::format("{}{}", fmt::join(names, ", "), traffic.empty() ? "" : " and " + traffic.name)};
  const std::string text = as_toml(result.draft);
  try {
    if (!result.wrote_database.empty()) write_whole(made_file, made->text);
    append(result.warnings, diagnostics::kind("log_content"), traffic.warnings);
    append(result.warnings, checked(text, options.out));
    write_whole(options.out, text);
  } catch (...) {
    if (!result.wrote_database.empty()) fs::remove(made_file);
    throw;
  }
  return result;
}

}  // namespace odomd::tools
