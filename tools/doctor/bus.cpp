#include "tools/doctor/doctor.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>
#include <linux/can.h>
#include <net/if.h>
#include <net/if_arp.h>
#include <sys/ioctl.h>
#include <sys/socket.h>

#include <algorithm>
#include <array>
#include <map>
#include <tuple>
#include <utility>

#include "base/file_descriptor.hpp"
#include "can_protocol/bus_names.hpp"
#include "can_protocol/decode/decoder.hpp"
#include "tools/diagnostics/kinds.hpp"
#include "tools/live/listen.hpp"
#include "tools/replay/replay_checks.hpp"

namespace odomd::tools::doctor {
namespace {

using diagnostics::Diagnostic;
using diagnostics::Diagnostics;
using diagnostics::found;

can::Decoder decoder_of(const Drive& drive) {
  return {drive.databases, drive.config.can.bindings, drive.config.can.protections, drive.buses};
}

can::IdFormat other(can::IdFormat format) {
  return format == can::IdFormat::standard ? can::IdFormat::extended : can::IdFormat::standard;
}

std::string id_text(const can::BoundMessage& message, can::IdFormat format) {
  return format == can::IdFormat::standard ? fmt::format("{:03X} (11 bits)", message.id)
                                           : fmt::format("{:08X} (29 bits)", message.id);
}

bool has_id(const can::BoundMessage& message, std::uint32_t id) {
  return ((message.id ^ id) & message.id_mask) == 0;
}

// Compares the rate of a message on one bus with that in the database. The replay compares the rate
// with the timeouts.
std::optional<Diagnostic> check_rate(const can::BoundMessage& message, const Identifier& seen) {
  constexpr const diagnostics::Kind& off = kind("other_rate");
  if (seen.rate_hz <= 0.0 || message.cycle_time_ns <= 0) return std::nullopt;
  const double usual_hz = 1e9 / static_cast<double>(message.cycle_time_ns);
  if (off.limits.hold(seen.rate_hz / usual_hz)) return std::nullopt;
  return found(off, fmt::format("message '{}' on {}", message.name, seen.bus),
               fmt::format("comes {:.3g} times a second, {:.3g} times according to the database",
                           seen.rate_hz, usual_hz),
               fmt::format("BA_ \"GenMsgCycleTime\" BO_ {} {:.0f};",
                           can::frame_key(message.id, message.format), 1e3 / seen.rate_hz));
}

}  // namespace

std::optional<Link> read_link(const std::string& interface) {
  const FileDescriptor control(::socket(AF_UNIX, SOCK_DGRAM | SOCK_CLOEXEC, 0));
  ifreq answer{};
  const auto asks = [&](unsigned long question) {
    answer = {};
    interface.copy(answer.ifr_name, IFNAMSIZ - 1);
    return control && ::ioctl(control.get(), question, &answer) == 0;
  };
  if (!asks(SIOCGIFFLAGS)) return std::nullopt;
  Link link;
  link.is_up = (answer.ifr_flags & IFF_UP) != 0;
  link.is_can = asks(SIOCGIFHWADDR) && answer.ifr_hwaddr.sa_family == ARPHRD_CAN;
  link.carries_fd = asks(SIOCGIFMTU) && answer.ifr_mtu >= static_cast<int>(CANFD_MTU);
  if (link.is_can) link.controller = can::read_controller(interface);
  return link;
}

can::FrameProtocol needed_protocol(const daemon::Config& config,
                                   std::span<const can::Database> databases) {
  for (const can::SignalBinding& binding : config.can.bindings)
    for (const can::Database& database : databases)
      if (const can::Message* const message = can::find_message(database, binding.message);
          message != nullptr && message->protocol == can::FrameProtocol::fd)
        return can::FrameProtocol::fd;
  return can::FrameProtocol::classic;
}

Diagnostics examine_link(const std::string& interface, const std::optional<Link>& link,
                         can::FrameProtocol needed) {
  const auto one = [&](const diagnostics::Kind& what, const std::string& seen) {
    return found(what, interface, seen, interface);
  };
  if (!link) return {one(kind("interface_missing"), "there is no such interface")};
  if (!link->is_can) return {one(kind("interface_not_can"), "is not a CAN interface")};
  Diagnostics all;
  const auto& controller = link->controller;
  const bool lacks_rate = controller && !controller->bit_timing;
  if (lacks_rate)
    all.push_back(one(kind("no_bit_rate"), "its controller has no bit rate"));
  else if (!link->is_up)
    all.push_back(one(kind("interface_down"), "is down"));
  if (needed == can::FrameProtocol::fd && !link->carries_fd)
    all.push_back(one(kind("no_can_fd"), "carries no CAN FD, which a mapped message needs"));
  if (!controller || lacks_rate) return all;
  if (controller->restart_ms == 0U) all.push_back(one(kind("no_restart"), "restart-ms is 0"));
  const can::ControllerHealth health = controller->health;
  if (health == can::ControllerHealth::error_warning ||
      health == can::ControllerHealth::error_passive) {
    const can_berr_counter errors = controller->errors.value_or(can_berr_counter{});
    all.push_back(one(kind("bus_errors"),
                      fmt::format("is {}, with error counters of {} (receive) and {} (transmit)",
                                  can::name_of(health), errors.rxerr, errors.txerr)));
  }
  if (health == can::ControllerHealth::bus_off) all.push_back(one(kind("bus_off"), "is bus-off"));
  return all;
}

void listen(Drive& drive, const std::vector<std::string>& interfaces,
            std::chrono::seconds duration) {
  drive.name = fmt::format("{}", fmt::join(interfaces, ", "));
  drive.folder = drive.name;
  drive.config.can.sources = interfaces;
  can::BusNames buses;
  for (const std::string& name : daemon::expected_buses(drive.config)) buses.index_of(name);
  drive.frames = tools::listen(interfaces, buses, drive.config.can.receive_buffer, duration);
  drive.buses = buses.all();
}

std::vector<Identifier> identifiers_of(const Drive& drive) {
  struct Times {
    std::uint64_t frames = 0;
    std::int64_t first_ns = 0, last_ns = 0;
  };
  std::map<std::tuple<std::uint8_t, can::IdFormat, std::uint32_t>, Times> seen;
  for (const auto* frames : {&drive.frames, &drive.unmapped})
    for (const can::Frame& frame : *frames) {
      if (frame.kind != can::FrameKind::data) continue;
      Times& times = seen[{frame.bus, frame.format, frame.id}];
      if (times.frames++ == 0) times.first_ns = frame.time_ns;
      times.last_ns = frame.time_ns;
    }
  const can::Decoder decoder = decoder_of(drive);
  std::vector<Identifier> all;
  for (const auto& [key, times] : seen) {
    const auto& [bus, format, id] = key;
    Identifier one{drive.buses.at(bus), id, format, times.frames, 0.0, {}};
    if (times.last_ns > times.first_ns)
      one.rate_hz = 1e9 * static_cast<double>(times.frames - 1) /
                    static_cast<double>(times.last_ns - times.first_ns);
    for (const can::BoundMessage& message : decoder.messages())
      if (message.format == format && has_id(message, id)) one.message = message.name;
    all.push_back(std::move(one));
  }
  return all;
}

Diagnostics examine_acknowledgement(const std::string& interface, const Link& link,
                                    const Drive& heard) {
  if (!link.controller ||
      std::ranges::find(link.controller->modes, "listen_only") == link.controller->modes.end())
    return {};
  std::vector<const can::Frame*> frames;
  for (const auto* list : {&heard.frames, &heard.unmapped})
    for (const can::Frame& frame : *list)
      if (frame.kind == can::FrameKind::data && heard.buses.at(frame.bus) == interface)
        frames.push_back(&frame);
  std::string seen = "is listen-only, and no frame comes";
  if (!frames.empty()) {
    const can::Frame& first = *frames.front();
    constexpr double without_pause_hz = 200.0;  // repeats exceed it at 50 kbit/s, idle nodes do not
    const double duration_s = 1e-9 * static_cast<double>(frames.back()->time_ns - first.time_ns);
    if (static_cast<double>(frames.size()) < 1.0 + without_pause_hz * duration_s ||
        frames.size() < 2 || !std::ranges::all_of(frames, [&](const can::Frame* frame) {
          return can::frame_key(*frame) == can::frame_key(first) &&
                 std::ranges::equal(frame->payload(), first.payload());
        }))
      return {};
    seen = fmt::format("is listen-only, and only {:03X} comes, {} times with the same payload",
                       first.id, frames.size());
  }
  return {found(kind("nobody_acknowledges"), interface, seen, interface)};
}

Diagnostics examine_traffic(const Drive& drive) {
  const std::vector<Identifier> seen = identifiers_of(drive);
  if (seen.empty()) return {found(kind("no_frames"), drive.name, "no frame came")};
  can::Decoder decoder = decoder_of(drive);
  const auto comes_as = [&](const can::BoundMessage& message, can::IdFormat format) {
    return std::ranges::any_of(seen, [&](const Identifier& one) {
      return one.format == format && has_id(message, one.id);
    });
  };
  if (decoder.messages().size() > 1 &&
      std::ranges::none_of(decoder.messages(), [&](const can::BoundMessage& message) {
        return comes_as(message, message.format) || comes_as(message, other(message.format));
      }))
    return {found(kind("other_database"), drive.name,
                  fmt::format("none of the {} mapped messages comes, but {} other identifiers",
                              decoder.messages().size(), seen.size()))};

  std::array<can::Sample, can::max_samples_per_frame> samples{};
  for (const can::Frame& frame : drive.frames)
    if (frame.kind == can::FrameKind::data) decoder.decode(frame, samples);
  Diagnostics all;
  for (std::size_t i = 0; i < decoder.messages().size(); ++i) {
    const can::BoundMessage& message = decoder.messages()[i];
    const can::IdFormat swapped = other(message.format);
    if (!comes_as(message, message.format) && comes_as(message, swapped)) {
      all.push_back(found(kind("other_id_format"), fmt::format("message '{}'", message.name),
                          fmt::format("comes as {}, but is {} in the database",
                                      id_text(message, swapped), id_text(message, message.format)),
                          std::to_string(can::frame_key(message.id, swapped))));
      continue;
    }
    append(all, check_message(message, decoder.counters(i)));
    for (const Identifier& one : seen)
      if (one.message == message.name) append(all, check_rate(message, one));
  }
  return all;
}

}  // namespace odomd::tools::doctor
