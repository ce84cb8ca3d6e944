// [can.signals]: the signal of each role, its unit and its uncertainty.
#include <algorithm>
#include <array>
#include <span>
#include <string_view>

#include <fmt/format.h>
#include <fmt/ranges.h>

#include "can_protocol/decode/units.hpp"
#include "daemon/core/config_sections.hpp"

namespace odomd::daemon {
namespace {

using can::Unit;
using estimator::Quantity;
using estimator::Source;

constexpr std::array angle{Unit::rad, Unit::deg};
constexpr std::array angular_rate{Unit::rad_per_s, Unit::deg_per_s};
constexpr std::array acceleration{Unit::m_per_s2, Unit::g};
constexpr std::array speed{Unit::m_per_s,   Unit::km_per_h,  Unit::rpm,
                           Unit::rad_per_s, Unit::deg_per_s, Unit::erpm};

Source role_named(const std::string& role, const TableReader& table) {
  const auto found = std::ranges::find(estimator::source_table, role, &estimator::SourceInfo::name);
  if (found == estimator::source_table.end()) {
    std::vector<std::string> all;
    for (const estimator::SourceInfo& source : estimator::source_table)
      if (source.quantity != Quantity::pose) all.emplace_back(source.name);
    table.fail("unknown role" + suggestion(role, all));
  }
  if (found->quantity == Quantity::pose)
    table.fail("the camera is not on the bus; configure it in its own table, [camera]");
  return static_cast<Source>(found - estimator::source_table.begin());
}

void read_signal_names(TableReader& table, can::SignalBinding& binding) {
  table.require("message");
  table.read("message", binding.message);
  const bool single = table.has("signal");
  if (single == table.has("sum"))
    table.fail(single ? "has both `signal` and `sum`; keep one"
                      : "names no signal; add signal = \"...\"");
  if (single) {
    table.read("signal", binding.signals.emplace_back());
  } else {
    table.read_texts("sum", binding.signals);
  }
}

/// Reads the keys that convert the rotation of a wheel or motor to a speed.
void read_rolling(TableReader& table, bool rolls, can::SignalBinding& binding) {
  if (!rolls)
    return table.refuse({"radius", "ratio", "pole_pairs"},
                        "applies only to wheels and motor with unit = \"rpm\", \"erpm\", \"rad/s\" "
                        "or \"deg/s\"");
  const auto unit = can::unit_name(binding.unit);
  if (!table.has("radius"))
    table.fail(
        "unit",
        fmt::format("\"{}\" needs `radius`, the rolling radius of the wheel in metres", unit));
  table.read("radius", binding.radius_m, {0.0, 10.0, false, "between 0 and 10 (m)"});
  table.read("ratio", binding.ratio,
             {0.0, 1000.0, false, "between 0 and 1000 (motor turns per wheel turn)"});
  if (binding.unit == Unit::erpm && !table.has("pole_pairs"))
    table.fail("unit", "\"erpm\" needs `pole_pairs`, the pole pairs of the motor");
  int pole_pairs = 1;
  table.read("pole_pairs", pole_pairs, 1, 100);
  binding.ratio *= pole_pairs;
}

void read_unit(TableReader& table, std::span<const Unit> possible, can::SignalBinding& binding) {
  std::vector<std::string> fitting;
  for (const Unit unit : possible) fitting.push_back(fmt::format("\"{}\"", can::unit_name(unit)));
  const auto list = fmt::format("{}", fmt::join(fitting, ", "));

  table.require("unit", "; it is one of " + list);
  std::string name;
  table.read("unit", name);
  const auto chosen =
      name == can::unit_name(Unit::none) ? std::optional(Unit::none) : can::unit_of_text(name);
  if (!chosen) table.fail("unit", fmt::format("\"{}\" is not known; it is one of {}", name, list));
  binding.unit = *chosen;
  if (binding.unit == Unit::none || binding.unit == Unit::percent) {
    if (!table.has("scale"))
      table.fail("unit", fmt::format("\"{}\" needs `scale`, which turns the number into the role's "
                                     "SI quantity",
                                     can::unit_name(binding.unit)));
  } else if (std::ranges::find(possible, binding.unit) == possible.end()) {
    table.fail("unit", fmt::format("\"{}\" does not fit this role; it is one of {}", name, list));
  }
  const bool is_speed = std::ranges::find(possible, Unit::rpm) != possible.end();
  read_rolling(table, is_speed && can::is_rotation(binding.unit), binding);
}

/// Forward and reverse are physical values of the signal: the sample is +1, -1 or 0.
void read_direction(TableReader& table, can::SignalBinding& binding) {
  if (binding.signals.size() > 1) table.fail("sum", "a direction is taken from one signal");
  table.refuse({"unit", "scale", "offset", "radius", "ratio", "pole_pairs", "sign"},
               "does not apply to a direction");
  table.require("forward");
  table.require("reverse");
  table.read("forward", binding.forward.emplace(), any_number);
  table.read("reverse", binding.reverse.emplace(), any_number);
  if (*binding.forward == *binding.reverse) table.fail("reverse", "is the same value as forward");
}

can::ValidWhen read_condition(TableReader condition) {
  can::ValidWhen valid_when;
  condition.require("signal");
  condition.read("signal", valid_when.signal);
  int comparisons = 0;
  for (std::size_t i = 0; i < can::comparison_names.size(); ++i) {
    if (!condition.has(can::comparison_names[i])) continue;
    ++comparisons;
    valid_when.comparison = static_cast<can::Comparison>(i);
    condition.read(can::comparison_names[i], valid_when.value, any_number);
  }
  condition.finish();
  if (comparisons != 1)
    condition.fail(fmt::format("needs one of {}", fmt::join(can::comparison_names, ", ")));
  return valid_when;
}

void read_unless_raw(TableReader& table, can::SignalBinding& binding) {
  using Pattern = can::UnlessRaw::Pattern;
  if (!table.has("unless_raw")) return;
  can::UnlessRaw& unless = binding.unless_raw.emplace();
  if (table.is_text("unless_raw")) {
    constexpr std::array<std::string_view, 2> names{"max", "all_ones"};
    unless.pattern =
        table.read_choice("unless_raw", names) == 0U ? Pattern::max : Pattern::all_ones;
  } else {
    table.read("unless_raw", unless.values);
  }
}

void read_sign(TableReader& table, can::SignalBinding& binding) {
  auto sign = table.table("sign", table.name() + " sign");
  if (!sign) return;
  binding.sign.emplace();
  sign->require("signal");
  sign->require("negative");
  sign->read("signal", binding.sign->signal);
  sign->read("negative", binding.sign->negative, any_number);
  sign->finish();
}

}  // namespace

std::span<const Unit> units_of(Source role) {
  switch (info_of(role).quantity) {
    case Quantity::yaw_rate:
      return angular_rate;
    case Quantity::acceleration:
      return acceleration;
    case Quantity::angle:
      return angle;
    default:
      return speed;
  }
}

void read_signal(const std::string& role, TableReader table, CanConfig& can) {
  const Source source = role_named(role, table);

  can::SignalBinding binding;
  binding.channel = static_cast<std::uint16_t>(source);
  binding.role = role;
  read_signal_names(table, binding);
  table.read("bus", binding.bus);
  if (table.has("source")) {
    int address = 0;
    table.read("source", address, 0, 255);
    binding.source = static_cast<std::uint8_t>(address);
  }
  if (source == Source::direction) {
    read_direction(table, binding);
  } else {
    table.refuse({"forward", "reverse"}, "belongs to the role direction");
    read_unit(table, units_of(source), binding);
    table.read("scale", binding.scale, any_number);
    if (binding.scale == 0.0) table.fail("scale", "must not be 0");
    table.read("offset", binding.offset, any_number);
    read_sign(table, binding);
  }
  for (TableReader& condition : table.tables("valid_when", table.name() + " valid_when"))
    binding.valid_when.push_back(read_condition(std::move(condition)));
  read_unless_raw(table, binding);
  table.read_seconds("latency", binding.latency_ns, {0.0, 1.0, true, "between 0 and 1 (s)"});

  SignalSettings& settings = can.signals[static_cast<std::size_t>(source)];
  settings.configured = true;
  settings.sigma = info_of(source).sigma;
  table.read("sigma", settings.sigma, positive);
  table.read_seconds("timeout", settings.timeout_ns, {0.0, 60.0, false, "between 0 and 60 (s)"});
  if (estimator::is_wheel(source)) {
    table.read("dead_band", settings.dead_band, {0.0, 3.0, true, "between 0 and 3 (m/s)"});
  } else {
    table.refuse({"dead_band"}, "applies only to wheels and motor; leave it out");
  }
  table.finish();
  can.bindings.push_back(std::move(binding));
}

}  // namespace odomd::daemon
