// odom dbc decode: a log's frames as physical values.
#include <fmt/format.h>

#include <array>
#include <cstdint>
#include <iostream>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "can_protocol/bus_names.hpp"
#include "can_protocol/dbc/dbc.hpp"
#include "can_protocol/dbc/message_index.hpp"
#include "can_protocol/dbc/signal_layout.hpp"
#include "can_protocol/sources/log_reader.hpp"
#include "tools/cli/output.hpp"
#include "tools/commands/dbc_commands.hpp"

namespace odomd::tools {
namespace {

using can::Database;
using can::Frame;
using can::IdFormat;
using can::Message;
using can::Signal;
using nlohmann::ordered_json;

struct DecodedSignal {
  const Signal* signal = nullptr;
  double value = 0.0;     ///< as a person writes it
  std::string_view name;  ///< of the value, from VAL_; empty if it has none
};

/// The name of a value, if there is one.
std::string_view value_name(const Signal& signal, double physical) {
  for (const auto& value : signal.values)
    if (static_cast<double>(value.raw) * signal.scale + signal.offset == physical)
      return value.name;
  return {};
}

/// The signals in the payload: selected by their multiplexors, and not cut off.
std::vector<DecodedSignal> decoded_signals(const Message& message, const Frame& frame) {
  std::vector<DecodedSignal> decoded;
  for (const Signal& signal : message.signals) {
    const can::SignalLayout layout = can::layout_of(signal);
    if (frame.length < layout.bytes_needed || !is_present(message, signal, frame.payload()))
      continue;
    const double value = physical_value(layout, extract_bits(layout, frame.payload()));
    decoded.push_back({&signal, as_written(layout, value), value_name(signal, value)});
  }
  return decoded;
}

/// Seconds with 6 decimals, or 9 if the stamp has them; integer arithmetic only.
std::string stamp_text(std::int64_t time_ns) {
  const std::int64_t seconds = time_ns / 1'000'000'000;
  const std::int64_t rest = time_ns % 1'000'000'000;
  return rest % 1000 == 0 ? fmt::format("{}.{:06}", seconds, rest / 1000)
                          : fmt::format("{}.{:09}", seconds, rest);
}

std::string_view kind_name(can::FrameKind kind) {
  constexpr std::array<std::string_view, 3> names{"data", "remote", "error"};
  return names[static_cast<std::size_t>(kind)];
}

std::string payload_text(const Frame& frame) {
  std::string text;
  for (const std::uint8_t byte : frame.payload()) text += fmt::format("{:02X}", byte);
  return text;
}

std::string json_line(const Frame& frame, const std::string& bus, const Message* message) {
  std::string line = "{\"t\":" + stamp_text(frame.time_ns) + ",\"bus\":" + json_text(bus) +
                     ",\"id\":" + std::to_string(frame.id);
  if (frame.format == IdFormat::extended) line += ",\"extended\":true";
  line += ",\"message\":" + (message == nullptr ? "null" : json_text(message->name));
  ordered_json signals = ordered_json::object();
  if (message != nullptr)
    for (const DecodedSignal& decoded : decoded_signals(*message, frame))
      signals[decoded.signal->name] = decoded.value;
  line += ",\"signals\":" + json_text(signals);
  if (message == nullptr)
    line += ",\"kind\":" + json_text(kind_name(frame.kind)) +
            ",\"data\":" + json_text(payload_text(frame));
  return line + "}\n";
}

std::string readable_line(const Frame& frame, const std::string& bus, const Message* message) {
  std::string line = '(' + stamp_text(frame.time_ns) + ") " + bus + ' ' +
                     hexadecimal(frame.id, frame.format) + ' ';
  if (message == nullptr)
    return line + "- " +
           (frame.kind == can::FrameKind::data ? payload_text(frame)
                                               : std::string(kind_name(frame.kind))) +
           '\n';
  line += message->name;
  for (const auto& [signal, value, name] : decoded_signals(*message, frame)) {
    line += "  " + signal->name + ' ' + shortest(value);
    if (!signal->unit.empty()) line += ' ' + signal->unit;
    if (!name.empty()) line.append(" (").append(name).append(")");
  }
  return line + '\n';
}

}  // namespace

void decode_log(const std::vector<std::string>& databases, const std::string& log, OutputForm form,
                Frames frames) {
  std::vector<Database> read;
  read.reserve(databases.size());
  for (const std::string& file : databases) read.push_back(can::read_dbc(file));
  const can::MessageIndex index(read);
  can::BusNames buses;
  can::LogReader reader(log, buses);
  std::vector<std::string> bus_names;
  while (const auto* frame = reader.next()) {
    const Message* message = frame->kind == can::FrameKind::data ? index.find(*frame) : nullptr;
    if (message == nullptr && frames == Frames::known) continue;
    if (frame->bus >= bus_names.size()) bus_names = buses.all();
    const std::string& bus = bus_names[frame->bus];
    std::cout << (form == OutputForm::json ? json_line(*frame, bus, message)
                                           : readable_line(*frame, bus, message));
    if (log == "-") std::cout.flush();  // a live source: lines as they come
  }
  // Last, so that a file that cannot be used is reported in one line.
  for (const Database& database : read)
    if (const std::size_t warnings = database.warnings.size(); warnings > 0)
      say(fmt::format("{0}: {1} {2}; odom dbc show {0} lists them", database.file, warnings,
                      warnings == 1 ? "warning" : "warnings"));
  for (const std::string& warning : reader.warnings()) say(warning);
}

}  // namespace odomd::tools
