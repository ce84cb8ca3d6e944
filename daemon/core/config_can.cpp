// [can]: the buses, the databases, end-to-end protection and the mapped signals.
#include <algorithm>
#include <array>
#include <optional>
#include <string_view>

#include <fmt/format.h>
#include <fmt/ranges.h>

#include "daemon/core/config_sections.hpp"

namespace odomd::daemon {
namespace {

using can::DataIdMode;
using can::E2eProfile;

constexpr std::array<std::string_view, 5> data_id_mode_names{"BOTH", "ALT", "LOW", "NIBBLE",
                                                             "ALTERNATING"};
constexpr std::array data_id_modes{DataIdMode::both, DataIdMode::alternating, DataIdMode::low,
                                   DataIdMode::nibble, DataIdMode::alternating};

/// A source is an interface, "-", or a log; the path of a log is relative to the configuration
/// file.
std::string resolve_source(const std::string& source, const std::filesystem::path& file) {
  const auto path = file.parent_path() / source;
  std::error_code error;
  const bool is_path = source.find('/') != std::string::npos || source.ends_with(".log");
  if (source == "-" || (!is_path && !std::filesystem::exists(path, error))) return source;
  return std::filesystem::absolute(path).lexically_normal().string();
}

}  // namespace

can::E2eBinding read_protection(const std::string& message, TableReader table) {
  can::E2eBinding binding;
  binding.message = message;
  table.require("profile",
                fmt::format("; it is one of {}", fmt::join(can::e2e_profile_names, ", ")));
  const auto profile = table.read_choice("profile", can::e2e_profile_names);
  binding.profile = static_cast<E2eProfile>(*profile);

  const bool by_data_id = binding.profile == E2eProfile::p01 || binding.profile == E2eProfile::p11;
  const bool by_list = binding.profile == E2eProfile::p02 || binding.profile == E2eProfile::p22;
  const bool has_crc =
      binding.profile != E2eProfile::counter && binding.profile != E2eProfile::none;
  const bool needs_counter = by_data_id || by_list || binding.profile == E2eProfile::counter;

  if (by_data_id) table.require("data_id");
  if (by_list) table.require("data_id_list");
  if (has_crc) table.require("crc");
  if (needs_counter) table.require("counter");

  // A key without effect points to a wrong profile. With "none" the other keys may stay, so that a
  // protection can be switched off temporarily.
  const auto refuse = [&](std::string_view key, bool belongs, std::string_view to) {
    if (binding.profile == E2eProfile::none || belongs || !table.has(key)) return;
    table.fail(key, fmt::format("belongs to {}, not to {}; leave it out, or fix the profile", to,
                                can::e2e_profile_names[*profile]));
  };
  refuse("data_id", by_data_id, "P01 and P11");
  refuse("data_id_mode", by_data_id, "P01 and P11");
  refuse("data_id_list", by_list, "P02 and P22");
  refuse("crc", has_crc, "the profiles with a CRC");
  refuse("max_delta_counter", needs_counter || table.has("counter"), "messages with a `counter`");

  int data_id = 0;
  table.read("data_id", data_id, 0, 0xFFFF);
  binding.data_id = static_cast<std::uint16_t>(data_id);
  if (const auto mode = table.read_choice("data_id_mode", data_id_mode_names))
    binding.data_id_mode = data_id_modes[*mode];
  table.read("data_id_list", binding.data_id_list, 16);
  table.read("crc", binding.crc_signal);
  table.read("counter", binding.counter_signal);
  int max_delta = binding.max_delta_counter;
  table.read("max_delta_counter", max_delta, 1, 14);
  binding.max_delta_counter = static_cast<std::uint8_t>(max_delta);
  table.finish();
  return binding;
}

std::optional<std::string> named_twice(std::vector<std::string> sources) {
  std::ranges::sort(sources);
  const auto twice = std::ranges::adjacent_find(sources);
  return twice == sources.end() ? std::nullopt : std::optional(*twice);
}

void read_buses(TableReader& table, CanConfig& can) {
  table.read_texts("source", can.sources);
  for (auto& source : can.sources) source = resolve_source(source, table.file());
  if (can.sources.size() > can::max_buses)
    table.fail("source", fmt::format("names {} buses; at most {} are allowed", can.sources.size(),
                                     can::max_buses));
  if (const auto twice = named_twice(can.sources))
    table.fail("source", fmt::format("names \"{}\" twice; leave one of them out", *twice));

  table.require("dbc", "; name the car's database");
  std::vector<std::string> databases;
  table.read_texts("dbc", databases);
  for (const auto& database : databases)
    can.dbc.push_back(
        std::filesystem::absolute(table.file().parent_path() / database).lexically_normal());
}

void read_messages(TableReader& table, CanConfig& can) {
  if (auto protections = table.table("e2e", "[can.e2e]"))
    for (auto& [message, entry] : protections->tables())
      can.protections.push_back(read_protection(message, std::move(entry)));

  table.require("signals", "; name the signal of each role in [can.signals]");
  auto signals = table.table("signals", "[can.signals]");
  for (auto& [role, entry] : signals->tables()) read_signal(role, std::move(entry), can);
  if (can.bindings.empty()) signals->fail("is empty; map at least a wheel speed");
}

}  // namespace odomd::daemon
