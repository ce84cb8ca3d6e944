#include "tools/import/frames.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <stdexcept>
#include <tuple>

#include <fmt/format.h>

#include "can_protocol/dbc/signal_layout.hpp"
#include "can_protocol/decode/message_encoder.hpp"
#include "tools/math/median.hpp"
#include "tools/sim/car_bus.hpp"

namespace odomd::tools {
namespace {

const sim::BusRole& target_of(std::string_view role) {
  // odomd.dbc has four wheels: one more speed takes the signal of a rear one, on another bus if
  // need be.
  const bool is_other_speed = role == "wheel_rear" || role == "motor";
  return *std::ranges::find(sim::bus_roles(), is_other_speed ? "wheel_rear_left" : role,
                            &sim::BusRole::role);
}

ImportedRole role_of(const MappedColumn& column, const std::vector<std::int64_t>& times_ns,
                     std::vector<std::string>& warnings) {
  const sim::BusRole& target = target_of(column.role);
  const can::Signal& signal =
      *can::find_signal(*can::find_message(sim::bus_database(), target.message), target.signal);
  ImportedRole role{.column = &column,
                    .message = target.message,
                    .signal = target.signal,
                    .unit = target.unit,
                    .values = column.values,
                    .least = std::numeric_limits<double>::max(),
                    .most = std::numeric_limits<double>::lowest()};
  double worst = 0.0;
  std::vector<double> steps;
  std::int64_t last_ns = 0;
  for (std::size_t row = 0; row < role.values.size(); ++row) {
    double& value = role.values[row];
    if (std::isnan(value)) {
      ++role.missing;
      continue;
    }
    if (value < signal.minimum || value > signal.maximum) {
      if (role.beyond++ == 0 || std::abs(value) > std::abs(worst)) worst = value;
      value = std::numeric_limits<double>::quiet_NaN();
      continue;
    }
    if (role.samples++ > 0) steps.push_back(static_cast<double>(times_ns[row] - last_ns) * 1e-9);
    last_ns = times_ns[row];
    role.least = std::min(role.least, value);
    role.most = std::max(role.most, value);
  }
  if (!steps.empty()) role.period_s = median_of(std::move(steps));
  const std::string who = fmt::format("{} ({})", column.role, column.place);
  const std::size_t all = role.samples + role.beyond;
  if (all == 0) throw std::invalid_argument(who + ": the column has no value; map another one");
  const std::string beyond =
      fmt::format("{}: {} of {} values are beyond {:g} to {:g} {}, up to {:.4g}", who, role.beyond,
                  all, signal.minimum, signal.maximum, role.unit, worst);
  // With more of them the unit is wrong.
  if (role.beyond * 10 > all)
    throw std::invalid_argument(beyond + "; check unit and scale of the column");
  if (role.beyond > 0) warnings.push_back(beyond + "; left out");
  return role;
}

bool come_together(const ImportedRole& a, const ImportedRole& b) {
  return a.column->table == b.column->table && a.signal != b.signal &&
         std::ranges::equal(
             a.values, b.values, {}, [](double x) { return std::isnan(x); },
             [](double x) { return std::isnan(x); });
}

}  // namespace

std::vector<ImportedRole> to_roles(const ColumnMap& map, const std::vector<TableRows>& tables,
                                   std::vector<std::string>& warnings) {
  std::vector<ImportedRole> roles;
  for (const MappedColumn& column : map.sensors) {
    ImportedRole role = role_of(column, tables[column.table].times_ns, warnings);
    // The first bus whose roles of this message all come together with it.
    const auto is_taken = [&](const ImportedRole& other) {
      return other.message == role.message && other.bus == role.bus && !come_together(role, other);
    };
    while (std::ranges::any_of(roles, is_taken)) ++role.bus;
    roles.push_back(std::move(role));
  }
  for (ImportedRole& role : roles)
    role.has_bus = std::ranges::any_of(roles, [&role](const ImportedRole& other) {
      return other.message == role.message && other.bus > 0;
    });
  return roles;
}

std::string bus_name(std::uint8_t bus) {
  return fmt::format("can{}", bus);
}

void send_frames(const std::vector<ImportedRole>& roles, const std::vector<TableRows>& tables,
                 std::int64_t shift_ns, const std::function<void(const can::Frame&)>& send) {
  struct Sender {
    can::MessageEncoder encoder;
    std::vector<const ImportedRole*> roles;
  };
  std::vector<Sender> senders;
  std::vector<std::tuple<std::int64_t, std::size_t, std::size_t>> due;  // time, sender, row
  for (const ImportedRole& role : roles) {
    const auto found = std::ranges::find_if(senders, [&role](const Sender& sender) {
      return sender.roles[0]->message == role.message && sender.roles[0]->bus == role.bus;
    });
    if (found != senders.end()) {
      found->roles.push_back(&role);
      continue;
    }
    const can::Message& message = *can::find_message(sim::bus_database(), role.message);
    const auto& times_ns = tables[role.column->table].times_ns;
    for (std::size_t row = 0; row < times_ns.size(); ++row)
      if (!std::isnan(role.values[row])) due.emplace_back(times_ns[row], senders.size(), row);
    senders.push_back({can::MessageEncoder(message, sim::bus_protection(message)), {&role}});
  }
  std::ranges::sort(due);
  for (const auto& [time_ns, sender, row] : due) {
    can::MessageEncoder& encoder = senders[sender].encoder;
    for (const ImportedRole* role : senders[sender].roles)
      encoder.set(role->signal, role->values[row]);
    send(encoder.frame(time_ns + shift_ns, senders[sender].roles[0]->bus));
  }
}

}  // namespace odomd::tools
