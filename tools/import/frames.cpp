#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <span>
#include <stdexcept>
#include <tuple>
#include <utility>

#include <fmt/format.h>

#include "can_protocol/decode/message_encoder.hpp"
#include "tools/import/import.hpp"
#include "tools/math/median.hpp"

namespace odomd::tools {
namespace {

const sim::BusRole& target_of(std::string_view role) {
  // odomd.dbc has four wheel speeds: any other speed uses the signal of a rear wheel, on another
  // bus if that is taken.
  const auto own = std::ranges::find(sim::bus_roles(), role, &sim::BusRole::role);
  if (own != sim::bus_roles().end()) return *own;
  return *std::ranges::find(sim::bus_roles(), "wheel_rear_left", &sim::BusRole::role);
}

const can::Message& message_of(const ImportedRole& role) {
  return *can::find_message(sim::bus_database(), role.target->message);
}

ImportedRole role_of(MappedColumn& column, const std::vector<std::int64_t>& times_ns,
                     std::vector<std::string>& warnings) {
  ImportedRole role{.column = &column, .target = &target_of(column.role)};
  const can::Signal& signal = *can::find_signal(message_of(role), role.target->signal);
  std::vector<double> values, beyond, steps;
  std::int64_t last_ns = 0;
  for (std::size_t row = 0; row < times_ns.size(); ++row) {
    double& value = column.values[row];
    if (value < signal.minimum || value > signal.maximum)
      beyond.push_back(std::exchange(value, std::numeric_limits<double>::quiet_NaN()));
    if (std::isnan(value)) continue;
    if (!values.empty()) steps.push_back(static_cast<double>(times_ns[row] - last_ns) * 1e-9);
    last_ns = times_ns[row];
    values.push_back(value);
  }
  const std::string who = fmt::format("{} ({})", column.role, column.place);
  const std::size_t all = values.size() + beyond.size();
  if (all == 0) throw std::invalid_argument(who + ": the column has no value; map another one");
  if (!beyond.empty()) {
    const std::string text = fmt::format(
        "{}: {} of {} values are beyond {:g} to {:g} {}, up to {:.4g}", who, beyond.size(), all,
        signal.minimum, signal.maximum, role.target->unit,
        *std::ranges::max_element(beyond, {}, [](double value) { return std::abs(value); }));
    // If more than a tenth of the values is outside the range, the unit is wrong.
    if (beyond.size() * 10 > all)
      throw std::invalid_argument(text + "; check unit and scale of the column");
    warnings.push_back(text + "; left out");
  }
  if (!steps.empty()) role.period_s = median_of(std::move(steps));
  role.report = {{"role", column.role},
                 {"column", column.place},
                 {"unit", column.unit},
                 {"unit_stated", column.unit_stated},
                 {"message", role.target->message},
                 {"signal", role.target->signal},
                 {"samples", values.size()},
                 {"missing", times_ns.size() - all},
                 {"beyond", beyond.size()},
                 {"period", role.period_s},
                 {"least", std::ranges::min(values)},
                 {"most", std::ranges::max(values)}};
  return role;
}

bool share_a_frame(const ImportedRole& a, const ImportedRole& b) {
  return a.target->message == b.target->message && a.bus == b.bus;
}

bool come_together(const ImportedRole& a, const ImportedRole& b) {
  return a.column->table == b.column->table && a.target->signal != b.target->signal &&
         std::ranges::equal(a.column->values, b.column->values,
                            [](double x, double y) { return std::isnan(x) == std::isnan(y); });
}

}  // namespace

std::vector<ImportedRole> to_roles(ColumnMap& map, std::vector<std::string>& warnings) {
  std::vector<ImportedRole> roles;
  for (MappedColumn& column : map.columns) {
    if (!column.is_sensor()) continue;
    ImportedRole role = role_of(column, map.tables[column.table].times_ns, warnings);
    // Use the first bus on which all other roles of this message come together with this role.
    const auto is_taken = [&](const ImportedRole& other) {
      return share_a_frame(other, role) && !come_together(role, other);
    };
    while (std::ranges::any_of(roles, is_taken)) ++role.bus;
    roles.push_back(std::move(role));
  }
  for (ImportedRole& role : roles) {
    role.has_bus = std::ranges::any_of(roles, [&role](const ImportedRole& other) {
      return other.target->message == role.target->message && other.bus > 0;
    });
    if (role.has_bus) role.report["bus"] = bus_name(role.bus);
  }
  return roles;
}

std::string bus_name(std::uint8_t bus) {
  return fmt::format("can{}", bus);
}

std::vector<can::Frame> frames_of(const std::vector<ImportedRole>& roles, const ColumnMap& map) {
  std::map<std::size_t, can::MessageEncoder> encoders;  // key: the first role of a frame
  std::vector<std::tuple<std::int64_t, std::size_t, std::size_t>> due;  // time, role, row
  for (std::size_t i = 0; i < roles.size(); ++i) {
    const auto has_frame = [&](const ImportedRole& other) {
      return share_a_frame(other, roles[i]);
    };
    if (std::ranges::any_of(std::span(roles).first(i), has_frame)) continue;
    const can::Message& message = message_of(roles[i]);
    encoders.emplace(i, can::MessageEncoder(message, sim::bus_protection(message)));
    const MappedColumn& column = *roles[i].column;
    for (std::size_t row = 0; row < column.values.size(); ++row)
      if (!std::isnan(column.values[row]))
        due.emplace_back(map.tables[column.table].times_ns[row], i, row);
  }
  std::ranges::sort(due);
  std::vector<can::Frame> frames;
  for (const auto& [time_ns, first, row] : due) {
    can::MessageEncoder& encoder = encoders.at(first);
    for (const ImportedRole& role : roles)
      if (share_a_frame(role, roles[first]))
        encoder.set(role.target->signal, role.column->values[row]);
    frames.push_back(encoder.frame(time_ns, roles[first].bus));
  }
  return frames;
}

}  // namespace odomd::tools
