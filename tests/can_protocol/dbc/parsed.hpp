// A parsed DBC text: its warnings, and its messages and signals as a listing to compare with.
#pragma once

#include <fmt/format.h>

#include <string>
#include <string_view>
#include <vector>

#include "can_protocol/dbc/dbc.hpp"

namespace odomd::can {

inline Database parse(std::string_view text) {
  return parse_dbc(text, "car.dbc");
}

inline std::vector<std::string> warnings_of(const Database& database) {
  std::vector<std::string> texts;
  for (const Warning& warning : database.warnings) texts.push_back(describe(database, warning));
  return texts;
}

/// "line: name start|length order type (scale,offset) [minimum|maximum]", then, if present, "unit",
/// short name, comment, values, M (it is a multiplexor), and its multiplexor's index with the raw
/// values that select it.
inline std::string listing(const Signal& signal) {
  constexpr std::string_view orders = "<>";  // little-endian, big-endian
  constexpr std::string_view types = "+-fd";
  std::string text =
      fmt::format(" {}: {} {}|{} {}{} ({},{}) [{}|{}]", signal.line, signal.name, signal.start_bit,
                  signal.length, orders.at(static_cast<std::size_t>(signal.byte_order)),
                  types.at(static_cast<std::size_t>(signal.type)), signal.scale, signal.offset,
                  signal.minimum, signal.maximum);
  if (!signal.unit.empty()) text += " \"" + signal.unit + '"';
  if (!signal.short_name.empty()) text += " short " + signal.short_name;
  if (!signal.comment.empty()) text += " # " + signal.comment;
  for (const ValueName& value : signal.values) text += fmt::format(" {}={}", value.raw, value.name);
  if (signal.is_multiplexor) text += " M";
  if (signal.multiplexor) text += fmt::format(" m{}", *signal.multiplexor);
  for (const MultiplexRange& range : signal.selected_by)
    text += fmt::format(" {}-{}", range.first, range.last);
  return text + '\n';
}

/// "line: name identifier length sender", then, if present, x (extended), fd, cycle time and
/// comment; then its signals.
inline std::string listing(const Message& message) {
  std::string text = fmt::format("{}: {} {} {} {}", message.line, message.name, message.id,
                                 message.length, message.sender);
  if (message.format == IdFormat::extended) text += " x";
  if (message.protocol == FrameProtocol::fd) text += " fd";
  if (message.cycle_time_ns != 0) text += fmt::format(" {} us", message.cycle_time_ns / 1000);
  if (!message.short_name.empty()) text += " short " + message.short_name;
  if (!message.comment.empty()) text += " # " + message.comment;
  text += '\n';
  for (const Signal& signal : message.signals) text += listing(signal);
  return text;
}

inline std::string listing(const Database& database) {
  std::string text;
  for (const Message& message : database.messages) text += listing(message);
  return text;
}

}  // namespace odomd::can
