#include "tools/identify/common/finding.hpp"

#include <fmt/format.h>

#include <cmath>
#include <cstdlib>
#include <exception>
#include <iostream>
#include <string_view>

#include "daemon/core/config_keys.hpp"
#include "tools/cli/output.hpp"
#include "tools/cli/text.hpp"
#include "tools/config_patch/config_patch.hpp"
#include "tools/diagnostics/kinds.hpp"
#include "tools/diagnostics/output.hpp"

namespace odomd::tools {
namespace {

/// Decimals that show the uncertainty with two digits: 4 for 0.0123.
int decimals_for(double uncertainty) {
  if (!(uncertainty > 0.0) || !std::isfinite(uncertainty)) return 6;
  const double digits = 1.0 - std::floor(std::log10(uncertainty));
  return static_cast<int>(std::fmin(std::fmax(digits, 0.0), 9.0));
}

/// The value rounded to two digits of its uncertainty: further digits have no meaning.
double rounded(double value, double sigma) {
  if (!(sigma > 0.0) || !std::isfinite(sigma) || !std::isfinite(value)) return value;
  const int decimals = static_cast<int>(1.0 - std::floor(std::log10(sigma)));
  if (decimals > 15) return value;
  if (decimals >= 0) return std::stod(fmt::format("{:.{}f}", value, decimals));
  const double step = std::pow(10.0, -decimals);
  return std::round(value / step) * step;
}

// The uncertainty in per cent with two digits.
std::string in_per_cent(const Finding& finding) {
  const std::string& key = finding.key;
  const double share = 200.0 * finding.sigma / std::fabs(finding.value);
  if (finding.share == Share::meaningless || !(share < 100.0) || key.ends_with(".offset") ||
      key.ends_with(".latency") || key.starts_with("imu.") || key.starts_with("camera."))
    return "";
  return fixed(share, share < 1.0 ? 2 : share < 10.0 ? 1 : 0) + " %";
}

ConfigValue config_value(const Findings& findings, const Finding& finding) {
  const double uncertainty = 2.0 * finding.sigma;
  std::string note =
      "odom identify " + findings.method + ": +- " + fixed(uncertainty, decimals_for(uncertainty));
  if (!finding.unit.empty()) note += " " + finding.unit;
  if (!findings.origin.empty()) note += ", " + findings.origin;
  return {finding.key, rounded(finding.value, finding.sigma), std::move(note)};
}

// The uncertainty in a note that an earlier method wrote; 0 if the note has none.
double uncertainty_in(const std::string& note) {
  constexpr std::string_view sign = ": +- ";
  const std::size_t at = note.find(sign);
  return at == std::string::npos ? 0.0 : std::strtod(note.c_str() + at + sign.size(), nullptr);
}

// Whether the values cannot be compared: the inertia from a fit includes the wheels' spin, as
// required by the filter, but the inertia from a swing does not.
bool are_different_quantities(const ConfigValue& before, const ConfigValue& value) {
  const auto is_fitted = [](const ConfigValue& each) {
    return each.note.find("odom identify fit:") != std::string::npos;
  };
  return value.key == "vehicle.yaw_inertia" && is_fitted(before) != is_fitted(value);
}

// Whether `before` is more precise by more than chance between two runs of an experiment.
bool is_more_precise(const ConfigValue& before, const ConfigValue& value) {
  constexpr double clearly = 1.3;
  const double was = uncertainty_in(before.note);
  return was > 0.0 && uncertainty_in(value.note) > clearly * was &&
         !are_different_quantities(before, value);
}

bool do_contradict(const ConfigValue& lhs, const ConfigValue& rhs) {
  constexpr double sigmas = 3.0;
  return std::fabs(lhs.value - rhs.value) >
         0.5 * sigmas * std::hypot(uncertainty_in(lhs.note), uncertainty_in(rhs.note));
}

// Whether the value suggests another car: a car's properties are known within a factor of two
// before they are measured, the noise and latencies of its sensors are not.
bool suggests_another_car(const ConfigValue& before, const ConfigValue& value) {
  constexpr double surprising = 2.0;
  if (!value.key.starts_with("vehicle.") || !(before.value > 0.0) || !(value.value > 0.0))
    return false;
  const double times = value.value / before.value;
  return times >= surprising || times <= 1.0 / surprising;
}

// The group of values that are only meaningful together: a tyre's curve, an actuator's delay, a
// signal's line, the axles of one wheelbase.
std::string_view group_of(std::string_view key) {
  const daemon::ConfigKey* row = daemon::config_key(key);
  if (row != nullptr && (row->table == "vehicle" || row->table == "steering") &&
      !row->group.empty())
    return row->group;
  if (key.ends_with(".scale") || key.ends_with(".offset")) return key.substr(0, key.rfind('.'));
  return key;
}

struct Candidate {
  Finding* finding;
  ConfigValue value;
  std::optional<ConfigValue> before;
  bool less_precise = false;
};

struct Writing {
  std::vector<ConfigValue> values;
  std::size_t kept = 0;  ///< values that stay since they are more precise
};

/// Marks findings that stay unwritten because the configuration has more precise values for the
/// whole group, and warns of values that should be checked.
Writing prepare(Findings& findings, const Delivery& delivery) {
  std::vector<Candidate> candidates;
  for (Finding& finding : findings.values) {
    if (finding.key.empty() || finding.determined == Determined::no || finding.use == Use::leave)
      continue;
    Candidate candidate{&finding, config_value(findings, finding),
                        value_in(delivery.write, finding.key)};
    candidate.less_precise =
        candidate.before && !delivery.force && is_more_precise(*candidate.before, candidate.value);
    candidates.push_back(std::move(candidate));
  }
  Writing writing;
  for (const Candidate& candidate : candidates) {
    const bool keep = std::ranges::all_of(candidates, [&](const Candidate& other) {
      return other.less_precise || group_of(other.value.key) != group_of(candidate.value.key);
    });
    if (keep) {
      Finding& finding = *candidate.finding;
      finding.use = Use::leave;
      finding.remark +=
          fmt::format("{}kept: the previous value is more precise (+- {:g}{}{})",
                      finding.remark.empty() ? "" : "; ", uncertainty_in(candidate.before->note),
                      finding.unit.empty() ? "" : " ", finding.unit);
      const ConfigValue &before = *candidate.before, &value = candidate.value;
      add_warning(findings.warnings, tools::kind("more_precise_kept"), delivery.write,
                  "{} stays {:.9g} ({}), which is more precise than {:.9g} +- {:g}{}", value.key,
                  before.value, before.note, value.value, uncertainty_in(value.note),
                  !do_contradict(before, value) ? ""
                                                : ", but they contradict each other: unless the "
                                                  "car has changed, measure again");
      ++writing.kept;
      continue;
    }
    if (candidate.before && suggests_another_car(*candidate.before, candidate.value))
      add_warning(findings.warnings, tools::kind("another_value"), delivery.write,
                  "{} was {:g} and becomes {:g}", candidate.value.key, candidate.before->value,
                  candidate.value.value);
    writing.values.push_back(candidate.value);
  }
  return writing;
}

// "2 keys written to car.toml: vehicle.mass, ...; 1 kept"
std::string report_of(const Writing& writing, const std::string& file) {
  if (writing.values.empty())
    return "nothing written to " + file +
           (writing.kept > 0 ? ": its values are more precise" : ": no key's value was determined");
  std::string keys;
  for (const ConfigValue& value : writing.values) keys += (keys.empty() ? "" : ", ") + value.key;
  return fmt::format("{} written to {}: {}{}", counted(writing.values.size(), "key"), file, keys,
                     writing.kept > 0 ? fmt::format("; {} kept", writing.kept) : "");
}

}  // namespace

void add_delivery(Command method, Delivery& delivery) {
  method.add_flag("--json", delivery.json, "Print the result as JSON");
  method.add("--write", "TOML", delivery.write,
             "Configuration to write the numbers to, each with a note on its origin; more precise "
             "numbers there are kept");
  method.add_flag("--force", delivery.force, "Also replace numbers that are more precise");
}

void raise_to_zero(Finding& latency) {
  if (!(latency.value < 0.0)) return;
  latency.remark += fmt::format("{}measured {} ms, but a latency cannot be negative",
                                latency.remark.empty() ? "" : "; ", fixed(1e3 * latency.value, 1));
  latency.value = 0.0;
}

std::string as_text(const Findings& findings) {
  Table table{.header = {"", "value", "+- 2 sigma", "unit", "", "key", ""},
              .rows = {},
              .flush_left = {0, 3, 5, 6}};
  for (const Finding& finding : findings.values) {
    const bool known = finding.determined == Determined::yes;
    const double uncertainty = 2.0 * finding.sigma;
    const int decimals = decimals_for(uncertainty);
    table.rows.push_back({finding.name, known ? fixed(finding.value, decimals) : "not determined",
                          known ? fixed(uncertainty, decimals) : "", finding.unit,
                          known ? in_per_cent(finding) : "", finding.key, finding.remark});
  }
  return table.text();
}

nlohmann::ordered_json as_json(const Findings& findings) {
  nlohmann::ordered_json json;
  json["method"] = findings.method;
  json["origin"] = findings.origin;
  for (const Finding& finding : findings.values) {
    nlohmann::ordered_json value{{"name", finding.name},
                                 {"key", finding.key},
                                 {"determined", finding.determined == Determined::yes},
                                 {"value", finding.value},
                                 {"sigma", finding.sigma},
                                 {"unit", finding.unit},
                                 {"remark", finding.remark}};
    if (finding.use == Use::leave) value["left_as_configured"] = true;
    json["values"].push_back(std::move(value));
  }
  json["warnings"] = texts_of(findings.warnings);
  json["diagnostics"] = as_json(findings.warnings);
  if (!findings.details.is_null()) json["details"] = findings.details;
  return json;
}

void check(const Delivery& delivery) {
  if (!delivery.write.empty()) check_patchable(delivery.write);
}

std::optional<Measured> measured_in(const std::string& file, const std::string& key) {
  const std::optional<ConfigValue> there = value_in(std::filesystem::path(file), key);
  if (!there) return std::nullopt;
  return Measured{there->value, 0.5 * uncertainty_in(there->note)};
}

void deliver(Findings findings, const Delivery& delivery) {
  Writing writing;
  std::exception_ptr problem;  // the numbers are printed even if writing fails
  try {
    if (!delivery.write.empty()) writing = prepare(findings, delivery);
  } catch (const std::exception&) {
    problem = std::current_exception();
  }
  warn("identify " + findings.method, findings.warnings);
  std::cout << (delivery.json ? json_text(as_json(findings)) + "\n"
                              : findings.table + as_text(findings))
            << std::flush;
  if (problem) std::rethrow_exception(problem);
  if (delivery.write.empty()) return;
  patch_config(delivery.write, writing.values);
  say("odom identify " + findings.method + ": " + report_of(writing, delivery.write));
}

}  // namespace odomd::tools
