#include "tools/init/init.hpp"

#include <algorithm>
#include <string>

#include <fmt/format.h>
#include <fmt/ranges.h>
#include <nlohmann/json.hpp>

#include "can_protocol/decode/units.hpp"
#include "tools/cli/text.hpp"
#include "tools/config_patch/config_patch.hpp"
#include "tools/init/proposal.hpp"

namespace odomd::tools {
namespace {

using estimator::Source;

/// The text as a TOML basic string.
std::string quoted(const std::string& text) {
  const std::string key = toml_key(text);
  return key.starts_with('"') ? key : '"' + key + '"';
}

std::string list_of(const std::vector<std::string>& names) {
  std::vector<std::string> quotes;
  for (const std::string& name : names) quotes.push_back(quoted(name));
  return names.size() == 1 ? quotes.front() : fmt::format("[{}]", fmt::join(quotes, ", "));
}

double rounded(double value) {
  return std::stod(fmt::format("{:.3g}", value));
}

std::string number(double value) {
  std::string text = shortest(value);
  return text.find_first_of(".e") == std::string::npos ? text + ".0" : text;
}

std::vector<std::string> signals_of(const Choice& choice) {
  std::vector<std::string> signals{choice.candidate.signal->name};
  if (choice.candidate.fraction != nullptr) signals.push_back(choice.candidate.fraction->name);
  return signals;
}

/// The keys for the sign and for the validity of samples.
std::string conditions(const Candidate& candidate) {
  std::vector<std::string> valid;
  for (const Companion& one : candidate.valid_when)
    if (one.value)
      valid.push_back(fmt::format("{{ signal = {}, equals = {} }}", quoted(one.signal->name),
                                  shortest(*one.value)));
  std::string text;
  if (candidate.sign)
    text += fmt::format(", sign = {{ signal = {}, negative = {} }}",
                        quoted(candidate.sign->signal->name), shortest(*candidate.sign->value));
  if (valid.size() == 1) text += ", valid_when = " + valid.front();
  if (valid.size() > 1) text += fmt::format(", valid_when = [{}]", fmt::join(valid, ", "));
  if (candidate.unless_raw)
    text += candidate.unless_raw->values.empty()
                ? ", unless_raw = \"all_ones\""
                : fmt::format(", unless_raw = [{}]", fmt::join(candidate.unless_raw->values, ", "));
  return text;
}

/// "{ message = ..., signal = ..., unit = ... }"
std::string entry(const Choice& choice) {
  const Candidate& candidate = choice.candidate;
  const auto signals = signals_of(choice);
  std::string text = fmt::format("{{ message = {}, ", quoted(candidate.message->name));
  text += signals.size() == 1 ? "signal = " + quoted(signals.front()) : "sum = " + list_of(signals);
  if (candidate.role == Source::direction) {
    text += fmt::format(", forward = {}, reverse = {}", shortest(candidate.forward.value()),
                        shortest(candidate.reverse.value()));
  } else {
    text += fmt::format(", unit = {}", quoted(std::string(can::unit_name(candidate.unit))));
    if (choice.radius) text += ", radius = " + number(*choice.radius);
    if (choice.ratio) text += ", ratio = " + number(*choice.ratio);
    if (choice.pole_pairs) text += ", pole_pairs = " + shortest(*choice.pole_pairs);
    if (choice.scale != 1.0) text += ", scale = " + number(choice.scale);
    if (choice.offset != 0.0) text += ", offset = " + number(choice.offset);
    if (choice.sigma) text += ", sigma = " + number(*choice.sigma);
  }
  text += conditions(candidate);
  if (choice.timeout) text += ", timeout = " + number(*choice.timeout);
  if (!choice.bus.empty()) text += ", bus = " + quoted(choice.bus);
  return text + " }";
}

/// Appends a comment, wrapped, with further lines indented.
void add_comment(std::string& text, std::string_view line) {
  constexpr std::size_t width = 118;
  std::string row = "#";
  while (!line.empty()) {
    const std::string_view word = line.substr(0, line.find(' '));
    if (row.size() + 1 + word.size() > width && row.size() > 1) {
      text += row + '\n';
      row = "#  ";
    }
    row.append(" ").append(word);
    line.remove_prefix(std::min(word.size() + 1, line.size()));
  }
  text += row + '\n';
}

std::string with_unsure(const VehicleValue& value) {
  return (value.sure ? "" : "UNSURE: ") + value.origin;
}

void add_signals(std::string& text, const Draft& draft) {
  text += "\n[can.signals]\n";
  std::vector<std::string> missing;
  for (const Source role : estimator::all_sources) {
    const auto& choice = draft.proposal.of(role);
    if (!choice) {
      if (role == Source::yaw_rate || role == Source::steering) missing.push_back(name_of(role));
      continue;
    }
    add_comment(text,
                fmt::format("{}{}{}", info_of(role).meaning, choice->reasons.empty() ? "" : ": ",
                            fmt::join(choice->reasons, "; ")));
    for (const std::string& warning : choice->warnings) add_comment(text, "UNSURE: " + warning);
    text += fmt::format("{} = {}\n", name_of(role), entry(*choice));
  }
  for (const std::string& role : missing)
    add_comment(text,
                fmt::format("UNSURE: nothing fits {}; without it the pose is less precise", role));
}

}  // namespace

std::vector<VehicleValue> vehicle_values(const Draft& draft) {
  const double mass = draft.car.mass.value();
  const double wheelbase = draft.car.wheelbase.value();
  const double front = draft.car.front_axle.value_or(0.5 * wheelbase);
  const double rear = std::stod(fmt::format("{:.6g}", wheelbase - front));
  const Typical typical = typical_for(wheelbase);
  const double weight = mass * car_model::gravity;
  const std::string guess = "typical of its class; odom identify ";
  const bool has_axle = draft.car.front_axle.has_value();
  const std::string axle_origin =
      has_axle ? "m, as given" : "m, half of the wheelbase; weigh both axles: odom identify cog";
  constexpr double above = 1.2, possible = 20.0;  // m/s²
  const double shown = above * draft.proposal.lateral;
  const double grip = rounded(shown < possible ? std::max(typical.grip, shown) : typical.grip);
  const std::string grip_origin = "m/s2, " + guess + "fit finds it";
  VehicleValue track{"track_width", 0.0, "m, as given"};
  if (draft.car.track) {
    track.value = *draft.car.track;
  } else if (!draft.proposal.measured_track) {
    track = {"track_width", rounded(0.6 * wheelbase), "m, typical; no role here needs it", false};
  } else {
    track.value = rounded(draft.proposal.measured_track.value());
    track.origin = "m, from wheels and gyro in the log; compare with a tape";
    track.sure = track.value > 0.3 * wheelbase && track.value < wheelbase;
  }
  return {
      {"mass", mass, "kg, as given"},
      {"front_axle", front, axle_origin, has_axle},
      {"rear_axle", rear, axle_origin, has_axle},
      {"yaw_inertia", rounded(typical.inertia * mass * front * rear),
       "kg m2, " + guess + "inertia measures it", false},
      {"cornering_stiffness_front", rounded(typical.stiffness_front * weight * rear / wheelbase),
       "N/rad, " + guess + "stiffness or fit measures it", false},
      {"cornering_stiffness_rear", rounded(typical.stiffness_rear * weight * front / wheelbase),
       "N/rad, " + guess + "stiffness or fit measures it", false},
      track,
      {"grip_front", grip, grip_origin, false},
      {"grip_rear", grip, grip_origin, false},
  };
}

std::string as_toml(const Draft& draft) {
  std::string text;
  add_comment(text, "Made by odom init from " + draft.made_from +
                        ". Look at each line marked UNSURE before the car drives by itself.");
  for (const std::string& note : draft.proposal.notes) add_comment(text, "Note: " + note + ".");
  text += "\n[vehicle]\n";
  for (const VehicleValue& value : vehicle_values(draft))
    text += fmt::format("{} = {} # {}\n", value.key, number(value.value), with_unsure(value));
  text += "\n[can]\n";
  if (draft.sources.empty())
    text += "# source = \"can0\" # the interface; or give --can\n";
  else
    text += fmt::format("source = {}\n", list_of(draft.sources));
  text += fmt::format("dbc = {}\n", list_of(draft.databases));
  if (!draft.protections.empty()) text += "\n[can.e2e]\n";
  for (const can::E2eBinding& protection : draft.protections)
    text += fmt::format(
        "{} = {{ profile = {}, data_id = 0x{:X}, crc = {}, counter = {} }}\n",
        toml_key(protection.message),
        quoted(
            std::string{can::e2e_profile_names.at(static_cast<std::size_t>(protection.profile))}),
        protection.data_id, quoted(protection.crc_signal), quoted(protection.counter_signal));
  add_signals(text, draft);
  text +=
      "\n# [imu] # if the sensor is not at the centre of gravity\n"
      "# position = [0.0, 0.0] # m, forward and to the left of the centre of gravity\n"
      "\n# [camera] # if a camera sends poses: docs/camera.md\n"
      "# lever_arm = [0.0, 0.0, 0.0] # m, m, rad: the point whose pose is sent, likewise, and its "
      "yaw\n";
  return text;
}

std::string as_text(const Draft& draft) {
  Table table{{"role", "signal", "unit", "sure"}, {}, {0, 1, 2, 3}};
  std::vector<std::pair<std::string, std::vector<std::string>>> warnings;  // with their roles
  const auto add_warning = [&](const std::string& warning, const std::string& whose) {
    auto found = std::ranges::find(warnings, warning, &decltype(warnings)::value_type::first);
    if (found == warnings.end()) found = warnings.insert(warnings.end(), {warning, {}});
    found->second.push_back(whose);
  };
  for (const auto& choice : draft.proposal.roles) {
    if (!choice) continue;
    const Candidate& candidate = choice->candidate;
    const bool has_unit = candidate.role != Source::direction;
    table.rows.push_back(
        {name_of(candidate.role),
         fmt::format("{}.{}", candidate.message->name, fmt::join(signals_of(*choice), " + ")),
         std::string(has_unit ? can::unit_name(candidate.unit) : "-"),
         choice->sure() ? "yes" : "no"});
    for (const std::string& warning : choice->warnings)
      add_warning(warning, name_of(candidate.role));
  }
  const std::vector<VehicleValue> vehicle = vehicle_values(draft);
  for (const VehicleValue& value : vehicle)
    if (!value.sure) add_warning(value.origin, value.key);
  std::string text = table.text();
  if (!warnings.empty() || !draft.proposal.notes.empty()) text += "Unsure:\n";
  for (const auto& [warning, whose] : warnings)
    text += fmt::format("  {}: {}\n", fmt::join(whose, ", "), warning);
  for (const std::string& note : draft.proposal.notes) text += fmt::format("  {}\n", note);
  return text;
}

nlohmann::ordered_json as_json(const Draft& draft) {
  using nlohmann::ordered_json;
  ordered_json roles = ordered_json::array();
  for (const auto& choice : draft.proposal.roles) {
    if (!choice) continue;
    const Candidate& candidate = choice->candidate;
    ordered_json role{{"role", name_of(candidate.role)},
                      {"message", candidate.message->name},
                      {"signals", signals_of(*choice)}};
    if (candidate.role == Source::direction) {
      role["forward"] = candidate.forward.value();
      role["reverse"] = candidate.reverse.value();
    } else {
      role["unit"] = can::unit_name(candidate.unit);
      role["scale"] = choice->scale;
      role["offset"] = choice->offset;
    }
    const auto optional = [&](const char* key, const std::optional<double>& value) {
      if (value) role[key] = *value;
    };
    optional("radius", choice->radius);
    optional("ratio", choice->ratio);
    optional("pole_pairs", choice->pole_pairs);
    optional("sigma", choice->sigma);
    optional("timeout", choice->timeout);
    if (!choice->bus.empty()) role["bus"] = choice->bus;
    role["sure"] = choice->sure();
    role["reasons"] = choice->reasons;
    role["warnings"] = choice->warnings;
    roles.push_back(std::move(role));
  }
  ordered_json vehicle = ordered_json::object();
  for (const VehicleValue& value : vehicle_values(draft))
    vehicle[value.key] = {{"value", value.value}, {"sure", value.sure}, {"origin", value.origin}};
  return {{"roles", std::move(roles)},
          {"vehicle", std::move(vehicle)},
          {"notes", draft.proposal.notes}};
}

}  // namespace odomd::tools
