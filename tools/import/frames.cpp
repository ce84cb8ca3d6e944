#include "tools/import/frames.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <stdexcept>

#include <fmt/format.h>

#include "can_protocol/dbc/signal_layout.hpp"
#include "can_protocol/decode/units.hpp"
#include "tools/cli/json_text.hpp"
#include "tools/sim/car_bus.hpp"

namespace odomd::tools {
namespace {

/// A unit is wrong if more of the values than this are impossible.
constexpr double max_share_beyond = 0.1;

// What a direction is sent as, in the signal of the steering on a bus of its own.
constexpr double sent_forward = 0.5;

const sim::BusRole& target_of(std::string_view role) {
  // odomd.dbc has four wheels: one more speed takes the signal of a rear one, on another bus if
  // need be.
  const std::string_view like = role == "wheel_rear" || role == "motor" ? "wheel_rear_left"
                                : role == "direction"                   ? "steering"
                                                                        : role;
  return *std::ranges::find(sim::bus_roles(), like, &sim::BusRole::role);
}

double si_value(const can::SignalBinding& binding, double value) {
  if (binding.forward && binding.reverse)
    return value == *binding.forward ? sent_forward : value == *binding.reverse ? -sent_forward : 0;
  double factor = can::si_factor(binding.unit);
  if (binding.unit == can::Unit::rpm) factor *= binding.radius_m / binding.ratio;
  return binding.scale * factor * value + binding.offset;
}

double median_period(const std::vector<std::int64_t>& times, const std::vector<double>& values) {
  std::vector<double> steps;
  std::int64_t last = no_time;
  for (std::size_t i = 0; i < times.size(); ++i) {
    if (std::isnan(values[i])) continue;
    if (last != no_time) steps.push_back(static_cast<double>(times[i] - last) * 1e-9);
    last = times[i];
  }
  if (steps.empty()) return 0.0;
  const auto middle = steps.begin() + static_cast<std::ptrdiff_t>(steps.size() / 2);
  std::ranges::nth_element(steps, middle);
  return *middle;
}

ImportedRole role_of(const SensorColumn& column, const Place& place, const TableRows& rows,
                     std::vector<std::string>& warnings) {
  const sim::BusRole& target = target_of(column.binding.role);
  const can::Signal& signal =
      *can::find_signal(*can::find_message(sim::bus_database(), target.message), target.signal);
  ImportedRole role{.role = column.binding.role,
                    .place = place.name,
                    .message = target.message,
                    .signal = target.signal,
                    .unit = target.unit,
                    .column_unit = can::unit_name(column.binding.unit),
                    .unit_stated = column.unit_stated,
                    .table = place.table,
                    .values = rows.values.at(place.column)};
  role.least = std::numeric_limits<double>::max();
  role.most = std::numeric_limits<double>::lowest();
  double worst = 0.0;
  for (double& value : role.values) {
    if (std::isnan(value)) {
      ++role.missing;
      continue;
    }
    value = si_value(column.binding, value);
    if (!(value >= signal.minimum && value <= signal.maximum)) {
      if (role.beyond++ == 0 || std::abs(value) > std::abs(worst)) worst = value;
      value = std::numeric_limits<double>::quiet_NaN();
      continue;
    }
    ++role.samples;
    role.least = std::min(role.least, value);
    role.most = std::max(role.most, value);
  }
  const std::string who = fmt::format("{} ({})", role.role, role.place);
  if (role.samples + role.beyond == 0)
    throw std::invalid_argument(who + ": the column has no value; map another one");
  const double share =
      static_cast<double>(role.beyond) / static_cast<double>(role.beyond + role.samples);
  const std::string beyond =
      fmt::format("{}: {} of {} values are beyond {:g} to {:g} {}, up to {:.4g}", who, role.beyond,
                  role.beyond + role.samples, signal.minimum, signal.maximum, role.unit, worst);
  if (share > max_share_beyond)
    throw std::invalid_argument(beyond + "; check unit and scale of the column");
  if (role.beyond > 0) warnings.push_back(beyond + "; left out");
  constexpr double few_steps = 20.0;
  if (const double span = role.most - role.least;
      span > 0.0 && span < few_steps * signal.scale && !column.binding.forward)
    warnings.push_back(fmt::format(
        "{}: its values vary by {:.2g} {} only, and are rounded to {:g}; check unit and scale", who,
        span, role.unit, signal.scale));
  role.period_s = median_period(rows.times_ns, role.values);
  return role;
}

bool come_together(const ImportedRole& a, const ImportedRole& b) {
  return a.table == b.table && a.signal != b.signal &&
         std::ranges::equal(a.values, b.values,
                            [](double x, double y) { return std::isnan(x) == std::isnan(y); });
}

}  // namespace

SensorFrames to_frames(const ColumnMap& map, const Tables& tables) {
  SensorFrames result;
  for (std::size_t i = 0; i < map.sensors.size(); ++i) {
    const Place& place = tables.sensors[i];
    result.roles.push_back(
        role_of(map.sensors[i], place, tables.rows[place.table], result.warnings));
  }
  for (const can::Message& message : sim::bus_database().messages) {
    const std::size_t first = result.groups.size();
    for (std::size_t i = 0; i < result.roles.size(); ++i) {
      const ImportedRole& role = result.roles[i];
      if (role.message != message.name) continue;
      const auto group =
          std::find_if(result.groups.begin() + static_cast<std::ptrdiff_t>(first),
                       result.groups.end(), [&](const FrameGroup& some) {
                         return std::ranges::all_of(some.roles, [&](std::size_t other) {
                           return come_together(role, result.roles[other]);
                         });
                       });
      if (group != result.groups.end())
        group->roles.push_back(i);
      else
        result.groups.push_back(
            {&message, static_cast<std::uint8_t>(result.groups.size() - first), role.table, {i}});
    }
    if (result.groups.size() > first + 1)
      for (std::size_t i = first; i < result.groups.size(); ++i)
        for (const std::size_t role : result.groups[i].roles)
          result.roles[role].bus = bus_name(result.groups[i].bus);
  }
  return result;
}

std::string bus_name(std::uint8_t bus) {
  return fmt::format("can{}", bus);
}

void send_frames(const SensorFrames& sensors, const Tables& tables, std::int64_t shift_ns,
                 const std::function<void(const can::Frame&)>& send) {
  struct Sender {
    const FrameGroup& group;
    can::MessageEncoder encoder;
    const std::vector<std::int64_t>& times;
    const std::vector<double>& values;  // of its first role: missing where those of all are
    std::size_t row = 0;

    void skip_missing() {
      while (row < times.size() && std::isnan(values[row])) ++row;
    }
    [[nodiscard]] std::int64_t next_ns() const {
      return row < times.size() ? times[row] : std::numeric_limits<std::int64_t>::max();
    }
  };
  std::vector<Sender> senders;
  for (const FrameGroup& group : sensors.groups) {
    senders.push_back(
        {group, can::MessageEncoder(*group.message, sim::bus_protection(*group.message)),
         tables.rows[group.table].times_ns, sensors.roles[group.roles.front()].values});
    senders.back().skip_missing();
  }
  while (true) {
    Sender& next = *std::ranges::min_element(senders, {}, &Sender::next_ns);
    if (next.row >= next.times.size()) return;
    for (const std::size_t role : next.group.roles)
      next.encoder.set(sensors.roles[role].signal, sensors.roles[role].values[next.row]);
    send(next.encoder.frame(next.next_ns() + shift_ns, next.group.bus));
    ++next.row;
    next.skip_missing();
  }
}

}  // namespace odomd::tools
