// odom dbc show: a database for people, or as JSON.
#include <algorithm>
#include <array>
#include <iostream>
#include <nlohmann/json.hpp>
#include <string>
#include <string_view>
#include <vector>

#include "can_protocol/dbc/dbc.hpp"
#include "tools/cli/output.hpp"
#include "tools/cli/text.hpp"
#include "tools/commands/dbc_commands.hpp"

namespace odomd::tools {
namespace {

using can::Database;
using can::IdFormat;
using can::Message;
using can::Signal;
using nlohmann::ordered_json;

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

}  // namespace

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

}  // namespace odomd::tools
