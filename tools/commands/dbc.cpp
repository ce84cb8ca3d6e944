// odom dbc: shows CAN databases and decodes logs with them.
#include <algorithm>
#include <array>
#include <cstdint>
#include <iostream>
#include <memory>
#include <string>
#include <string_view>
#include <vector>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "can_protocol/bus_names.hpp"
#include "can_protocol/dbc/dbc.hpp"
#include "can_protocol/dbc/message_index.hpp"
#include "can_protocol/dbc/signal_layout.hpp"
#include "can_protocol/frame.hpp"
#include "can_protocol/sources/log_reader.hpp"
#include "tools/cli/output.hpp"
#include "tools/cli/text.hpp"
#include "tools/commands/commands.hpp"
#include "tools/replay/log_options.hpp"

namespace odomd::tools {
namespace {

using can::Database;
using can::Frame;
using can::IdFormat;
using can::Message;
using can::Signal;
using nlohmann::ordered_json;

enum class OutputForm : std::uint8_t { readable, json };
enum class Frames : std::uint8_t { known, all };

// As candump prints it: 3 digits, or 8 for an extended identifier.
std::string hexadecimal(std::uint32_t id, IdFormat format) {
  return format == IdFormat::extended ? fmt::format("{:08X}", id) : fmt::format("{:03X}", id);
}

std::string_view type_name(can::ValueType type) {
  constexpr std::array<std::string_view, 4> names{"unsigned", "signed", "float", "double"};
  return names[static_cast<std::size_t>(type)];
}

ordered_json signal_json(const Message& message, const Signal& signal) {
  ordered_json json{
      {"name", signal.name},
      {"short_name", signal.short_name},
      {"start", signal.start_bit},
      {"length", signal.length},
      {"byte_order",
       signal.byte_order == can::ByteOrder::little_endian ? "little_endian" : "big_endian"},
      {"type", type_name(signal.type)},
      {"scale", signal.scale},
      {"offset", signal.offset},
      {"min", signal.minimum},
      {"max", signal.maximum},
      {"unit", signal.unit},
      {"comment", signal.comment},
      {"multiplexor", signal.is_multiplexor}};
  if (signal.multiplexor) {
    ordered_json ranges = ordered_json::array();
    for (const auto& range : signal.selected_by) ranges.push_back({range.first, range.last});
    json["selected_by"] = {{"signal", message.signals[*signal.multiplexor].name},
                           {"ranges", ranges}};
  }
  ordered_json values = ordered_json::object();
  for (const auto& value : signal.values) values[std::to_string(value.raw)] = value.name;
  json["values"] = values;
  return json;
}

ordered_json database_json(const Database& database) {
  ordered_json messages = ordered_json::array();
  for (const Message& message : database.messages) {
    ordered_json signals = ordered_json::array();
    for (const Signal& signal : message.signals) signals.push_back(signal_json(message, signal));
    messages.push_back({{"name", message.name},
                        {"short_name", message.short_name},
                        {"id", message.id},
                        {"extended", message.format == IdFormat::extended},
                        {"length", message.length},
                        {"fd", message.protocol == can::FrameProtocol::fd},
                        {"cycle_time_ms", static_cast<double>(message.cycle_time_ns) / 1e6},
                        {"sender", message.sender},
                        {"comment", message.comment},
                        {"signals", signals}});
  }
  ordered_json warnings = ordered_json::array();
  for (const auto& warning : database.warnings)
    warnings.push_back({{"line", warning.line}, {"text", warning.text}});
  return {{"file", database.file}, {"messages", messages}, {"warnings", warnings}};
}

/// "M", "m3", "m0-2,5 of Page"
std::string multiplexing_text(const Message& message, const Signal& signal) {
  std::string text;
  if (signal.multiplexor) {
    for (const auto& range : signal.selected_by) {
      text += (text.empty() ? "m" : ",") + std::to_string(range.first);
      if (range.last != range.first) text += '-' + std::to_string(range.last);
    }
    if (text.empty()) text = "no value";
    text += " of " + message.signals[*signal.multiplexor].name;
  }
  if (signal.is_multiplexor) text += text.empty() ? "multiplexor" : ", multiplexor";
  return text;
}

std::string one_line(std::string text) {
  std::replace(text.begin(), text.end(), '\n', ' ');
  return text;
}

/// "LongName (short)"
template <typename Named>
std::string both_names(const Named& named) {
  return named.short_name.empty() ? named.name : named.name + " (" + named.short_name + ')';
}

void print_message(const Message& message) {
  std::cout << '\n'
            << hexadecimal(message.id, message.format) << ' ' << both_names(message) << "  id "
            << message.id << (message.format == IdFormat::extended ? " extended, " : ", ")
            << (message.id_mask == can::whole_id ? "" : "J1939, ") << int{message.length}
            << (message.length == 1 ? " byte" : " bytes")
            << (message.protocol == can::FrameProtocol::fd ? ", CAN FD" : "");
  if (message.cycle_time_ns > 0)
    std::cout << ", every " << shortest(static_cast<double>(message.cycle_time_ns) / 1e6) << " ms";
  if (!message.sender.empty()) std::cout << ", from " << message.sender;
  std::cout << '\n';
  if (!message.comment.empty()) std::cout << "  " << one_line(message.comment) << '\n';
  if (message.signals.empty()) return;
  Table table{{"  signal", "bits", "order", "type", "factor", "offset", "range", "unit",
               "multiplexing", "comment"},
              {},
              {0, 1, 2, 3, 4, 5, 6, 7, 8, 9}};
  for (const Signal& signal : message.signals) {
    std::string range;
    if (signal.minimum != 0.0 || signal.maximum != 0.0)
      range = shortest(signal.minimum) + " to " + shortest(signal.maximum);
    table.rows.push_back({"  " + both_names(signal),
                          std::to_string(signal.start_bit) + '|' + std::to_string(signal.length),
                          signal.byte_order == can::ByteOrder::little_endian ? "little" : "big",
                          std::string(type_name(signal.type)), shortest(signal.scale),
                          shortest(signal.offset), range, signal.unit,
                          multiplexing_text(message, signal), one_line(signal.comment)});
  }
  std::cout << table.text();
}

struct DecodedSignal {
  const Signal* signal = nullptr;
  double value = 0.0;     ///< physical value in its decimal form
  std::string_view name;  ///< name of the value in VAL_; empty if it has none
};

/// The name of the value; empty if it has none.
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

// Warnings go to standard error.
void show_dbc(const std::string& file, OutputForm form) {
  const Database database = can::read_dbc(file);
  if (form == OutputForm::json) {
    std::cout << json_text(database_json(database), 2) << '\n';
    return;
  }
  std::size_t signals = 0;
  for (const Message& message : database.messages) signals += message.signals.size();
  std::cout << database.file << ": " << database.messages.size() << " messages, " << signals
            << " signals\n";
  for (const Message& message : database.messages) print_message(message);
  for (const auto& warning : database.warnings) say(describe(database, warning));
}

// One line per frame; of several databases, the first that knows the identifier decodes it.
void decode_log(const std::vector<std::string>& databases, const std::string& log, OutputForm form,
                Frames frames, can::Damage damage) {
  std::vector<Database> read;
  read.reserve(databases.size());
  for (const std::string& file : databases) read.push_back(can::read_dbc(file));
  const can::MessageIndex index(read);
  can::BusNames buses;
  can::LogReader reader(log, buses, damage);
  std::vector<std::string> bus_names;
  while (const auto* frame = reader.next()) {
    const Message* message = frame->kind == can::FrameKind::data ? index.find(*frame) : nullptr;
    if (message == nullptr && frames == Frames::known) continue;
    if (frame->bus >= bus_names.size()) bus_names = buses.all();
    const std::string& bus = bus_names[frame->bus];
    std::cout << (form == OutputForm::json ? json_line(*frame, bus, message)
                                           : readable_line(*frame, bus, message));
    if (log == "-") std::cout.flush();  // a live source: flush each line
  }
  // Warnings come last, so that the error about an unusable file is the only line.
  for (const Database& database : read)
    if (const std::size_t warnings = database.warnings.size(); warnings > 0)
      say(fmt::format("{0}: {1} {2}; odom dbc show {0} lists them", database.file, warnings,
                      warnings == 1 ? "warning" : "warnings"));
  for (const std::string& warning : reader.warnings()) say(warning);
}

}  // namespace

void add_dbc(Command odom) {
  struct Options {
    std::string file;
    std::vector<std::string> databases;
    std::string log;
    OutputForm form = OutputForm::readable;
    Frames frames = Frames::known;
    can::Damage damage = can::Damage::left_out;
  };
  const auto options = std::make_shared<Options>();

  Command dbc = odom.add_subcommand("dbc", "Show CAN databases and decode logs with them");
  dbc.require_subcommand();
  dbc.footer(
      "Examples:\n"
      "  odom dbc show car.dbc\n"
      "  odom dbc decode --dbc car.dbc drive.log\n"
      "odom dbc show --help and odom dbc decode --help have more.");

  Command show_command = dbc.add_subcommand("show", "Print the messages and signals of a DBC");
  show_command.add("DBC", "", options->file, "Database (DBC)", {required()});
  show_command.add_flag("--json", options->form, OutputForm::json, "Print the database as JSON");
  show_command.footer(
      "Examples:\n"
      "  odom dbc show car.dbc\n"
      "  odom dbc show --json car.dbc | jq '.messages[].name'");
  show_command.callback([options] { show_dbc(options->file, options->form); });

  Command decode_command = dbc.add_subcommand("decode", "Decode a candump log, one line per frame");
  decode_command.add("--dbc", "DBC", options->databases,
                     "Database (DBC); repeatable: the first that contains the identifier is used",
                     {required(), one_each()});
  decode_command.add("LOG", "", options->log, "Log of candump -L, or - for standard input",
                     {required()});
  decode_command.add_flag("--json", options->form, OutputForm::json,
                          "Print each frame as JSON, one per line");
  decode_command.add_flag("--all", options->frames, Frames::all,
                          "Also print frames that are in no database");
  add_strict(decode_command, options->damage);
  decode_command.footer(
      "Examples:\n"
      "  odom dbc decode --dbc car.dbc drive.log\n"
      "  odom dbc decode --dbc powertrain.dbc --dbc chassis.dbc --json drive.log\n"
      "  candump -L can0 | odom dbc decode --dbc car.dbc -");
  decode_command.callback([options] {
    decode_log(options->databases, options->log, options->form, options->frames, options->damage);
  });
}

}  // namespace odomd::tools
