#include "tools/identify/common/delivery.hpp"

#include <fmt/format.h>

#include <cmath>
#include <cstdlib>
#include <iostream>
#include <string_view>

#include "daemon/diagnostics/diagnostic.hpp"
#include "tools/cli/json_text.hpp"
#include "tools/cli/output.hpp"
#include "tools/cli/text.hpp"
#include "tools/config_patch/config_patch.hpp"
#include "tools/diagnostics/output.hpp"

namespace odomd::tools {
namespace {

/// So that the uncertainty shows two digits: 0.0123 gives 4 decimals.
int decimals_for(double uncertainty) {
  if (!(uncertainty > 0.0) || !std::isfinite(uncertainty)) return 6;
  const double digits = 1.0 - std::floor(std::log10(uncertainty));
  return static_cast<int>(std::fmin(std::fmax(digits, 0.0), 9.0));
}

/// To two digits of its uncertainty: more would have no meaning.
double rounded(double value, double sigma) {
  if (!(sigma > 0.0) || !std::isfinite(sigma) || !std::isfinite(value)) return value;
  const int decimals = static_cast<int>(1.0 - std::floor(std::log10(sigma)));
  if (decimals > 15) return value;
  if (decimals >= 0) return std::stod(fmt::format("{:.{}f}", value, decimals));
  const double step = std::pow(10.0, -decimals);
  return std::round(value / step) * step;
}

bool share_is_meaningful(const Finding& finding) {
  const std::string& key = finding.key;
  return finding.share == Share::meaningful && 2.0 * finding.sigma < std::fabs(finding.value) &&
         !key.ends_with(".offset") && !key.ends_with(".latency") && !key.starts_with("imu.") &&
         !key.starts_with("camera.");
}

// With two digits, as the uncertainty itself.
std::string in_per_cent(const Finding& finding) {
  if (!share_is_meaningful(finding)) return "";
  const double share = 200.0 * finding.sigma / std::fabs(finding.value);
  return fixed(share, share < 1.0 ? 2 : share < 10.0 ? 1 : 0) + " %";
}

std::vector<ConfigValue> config_values(const Findings& findings) {
  std::vector<ConfigValue> values;
  for (const Finding& finding : findings.values) {
    if (finding.key.empty() || finding.determined == Determined::no || finding.use == Use::leave)
      continue;
    const double uncertainty = 2.0 * finding.sigma;
    std::string note = "odom identify " + findings.method + ": +- " +
                       fixed(uncertainty, decimals_for(uncertainty));
    if (!finding.unit.empty()) note += " " + finding.unit;
    if (!findings.origin.empty()) note += ", " + findings.origin;
    values.push_back({finding.key, rounded(finding.value, finding.sigma), std::move(note)});
  }
  return values;
}

// The uncertainty in a note of ours.
double uncertainty_in(const std::string& note) {
  constexpr std::string_view sign = ": +- ";
  const std::size_t at = note.find(sign);
  return at == std::string::npos ? 0.0 : std::strtod(note.c_str() + at + sign.size(), nullptr);
}

// The car's properties are known within a factor of two before they are measured; the noise and
// latencies of its sensors are not.
bool of_another_car(const ConfigValue& before, const ConfigValue& value) {
  constexpr double surprising = 2.0;
  if (!value.key.starts_with("vehicle.") || !(before.value > 0.0) || !(value.value > 0.0))
    return false;
  const double times = value.value / before.value;
  return times >= surprising || times <= 1.0 / surprising;
}

// A fit's inertia includes the wheels' spin, as the filter needs it, and a swing's does not: the
// two cannot be compared.
bool of_another_quantity(const ConfigValue& before, const ConfigValue& value) {
  constexpr std::string_view by_fit = "odom identify fit:";
  return value.key == "vehicle.yaw_inertia" &&
         before.note.starts_with(by_fit) != value.note.starts_with(by_fit);
}

// More than the scatter of one experiment done twice.
bool less_sure(const ConfigValue& before, const ConfigValue& value) {
  constexpr double clearly = 1.3;
  const double was = uncertainty_in(before.note);
  return was > 0.0 && uncertainty_in(value.note) > clearly * was &&
         !of_another_quantity(before, value);
}

bool contradict(const ConfigValue& one, const ConfigValue& other) {
  constexpr double sigmas = 3.0;
  return std::fabs(one.value - other.value) >
         0.5 * sigmas * std::hypot(uncertainty_in(one.note), uncertainty_in(other.note));
}

// Warnings about replaced values that should be checked.
diagnostics::Diagnostics delivery_warnings(const std::vector<ConfigValue>& values,
                                           const std::string& file) {
  diagnostics::Diagnostics warnings;
  for (const ConfigValue& value : values) {
    const std::optional<ConfigValue> before = value_in(file, value.key);
    if (!before) continue;
    if (of_another_car(*before, value))
      warnings.push_back(found(
          diagnostics::kind("another_value"), file,
          fmt::format("{} was {:g} and becomes {:g}", value.key, before->value, value.value)));
    else if (less_sure(*before, value))
      warnings.push_back(
          found(diagnostics::kind("previous_more_precise"), file,
                fmt::format(
                    "the previous value of {} was more precise: {:.9g} ({}); it becomes {:.9g} +- "
                    "{:g}{}",
                    value.key, before->value, before->note, value.value, uncertainty_in(value.note),
                    contradict(*before, value) ? ": they contradict each other" : "")));
  }
  return warnings;
}

// "2 keys written to car.toml: vehicle.mass, ..."
std::string report_of(const std::vector<ConfigValue>& values, const std::string& file) {
  if (values.empty()) return "nothing written to " + file + ": no key's value was determined";
  std::string keys;
  for (const ConfigValue& value : values) keys += (keys.empty() ? "" : ", ") + value.key;
  return fmt::format("{} written to {}: {}", counted(values.size(), "key"), file, keys);
}

}  // namespace

void add_delivery(Command method, Delivery& delivery) {
  method.add_flag("--json", delivery.json, "One JSON object instead of a table");
  method
      .add_option("--write", delivery.write,
                  "Configuration to write the numbers to, each with a note on its origin")
      .type_name("TOML");
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

void deliver(const Findings& findings, const Delivery& delivery) {
  warn("identify " + findings.method, findings.warnings);
  std::cout << (delivery.json ? json_text(as_json(findings)) + "\n" : as_text(findings))
            << std::flush;
  if (delivery.write.empty()) return;
  const std::vector<ConfigValue> values = config_values(findings);
  const diagnostics::Diagnostics warnings = delivery_warnings(values, delivery.write);
  patch_config(delivery.write, values);
  warn("identify " + findings.method, warnings);
  say("odom identify " + findings.method + ": " + report_of(values, delivery.write));
}

}  // namespace odomd::tools
