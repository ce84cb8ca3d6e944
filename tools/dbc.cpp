// odom dbc: looks into CAN databases and decodes logs by them.
#include <algorithm>
#include <array>
#include <cstdint>
#include <cstdio>
#include <iomanip>
#include <iostream>
#include <memory>
#include <nlohmann/json.hpp>
#include <sstream>
#include <stdexcept>
#include <string>
#include <unordered_map>
#include <vector>

#include "can_protocol/bus_names.hpp"
#include "can_protocol/dbc.hpp"
#include "can_protocol/log_reader.hpp"
#include "can_protocol/signal_layout.hpp"
#include "tools/commands.hpp"

namespace odomd::tools {
namespace {

using can::Database;
using can::Frame;
using can::IdFormat;
using can::Message;
using can::Signal;
using nlohmann::ordered_json;

enum class OutputForm : std::uint8_t { readable, json };

/// JSON text; bytes that are no UTF-8 are replaced.
std::string dumped(const ordered_json& value) {
  return value.dump(-1, ' ', false, ordered_json::error_handler_t::replace);
}

/// Shortest decimal form that reads back the same, for people: 5, not 5.0.
std::string shortest(double value) {
  std::string text = dumped(value);
  if (text.ends_with(".0")) text.resize(text.size() - 2);
  return text == "null" ? "nan" : text;  // JSON has no word for it
}

std::string hexadecimal(std::uint32_t id, IdFormat format) {
  std::array<char, 16> text{};
  std::snprintf(text.data(), text.size(), format == IdFormat::extended ? "%08X" : "%03X", id);
  return text.data();
}

std::string_view type_name(can::ValueType type) {
  switch (type) {
    case can::ValueType::unsigned_integer:
      return "unsigned";
    case can::ValueType::signed_integer:
      return "signed";
    case can::ValueType::float32:
      return "float";
    case can::ValueType::float64:
      return "double";
  }
  return "";
}

// odom dbc show -----------------------------------------------------------------------------------

ordered_json signal_json(const Message& message, const Signal& signal) {
  ordered_json json{
      {"name", signal.name},
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
    text += " of " + message.signals[*signal.multiplexor].name;
  }
  if (signal.is_multiplexor) text += text.empty() ? "multiplexor" : ", multiplexor";
  return text;
}

/// Characters on a terminal: UTF-8 bytes that begin one.
std::size_t width(const std::string& text) {
  return static_cast<std::size_t>(std::count_if(text.begin(), text.end(), [](char c) {
    return (static_cast<unsigned char>(c) & 0xC0U) != 0x80U;
  }));
}

/// Rows in columns as wide as their widest cell, the last one as it is.
void print_columns(const std::vector<std::vector<std::string>>& rows) {
  std::vector<std::size_t> widths;
  for (const auto& row : rows) {
    widths.resize(std::max(widths.size(), row.size()));
    for (std::size_t i = 0; i < row.size(); ++i) widths[i] = std::max(widths[i], width(row[i]));
  }
  for (const auto& row : rows) {
    std::string line = " ";
    for (std::size_t i = 0; i < row.size(); ++i) {
      line += ' ' + row[i];
      line.append(widths[i] - width(row[i]) + 1, ' ');
    }
    std::cout << line.substr(0, line.find_last_not_of(' ') + 1) << '\n';
  }
}

std::string one_line(std::string text) {
  std::replace(text.begin(), text.end(), '\n', ' ');
  return text;
}

void print_message(const Message& message) {
  std::cout << '\n'
            << hexadecimal(message.id, message.format) << ' ' << message.name << "  id "
            << message.id << (message.format == IdFormat::extended ? " extended, " : ", ")
            << int{message.length} << (message.length == 1 ? " byte" : " bytes")
            << (message.protocol == can::FrameProtocol::fd ? ", CAN FD" : "");
  if (message.cycle_time_ns > 0)
    std::cout << ", every " << shortest(static_cast<double>(message.cycle_time_ns) / 1e6) << " ms";
  if (!message.sender.empty()) std::cout << ", from " << message.sender;
  std::cout << '\n';
  if (!message.comment.empty()) std::cout << "  " << one_line(message.comment) << '\n';
  if (message.signals.empty()) return;
  std::vector<std::vector<std::string>> rows{{"signal", "bits", "order", "type", "factor", "offset",
                                              "range", "unit", "multiplexing", "comment"}};
  for (const Signal& signal : message.signals) {
    std::string range;
    if (signal.minimum != 0.0 || signal.maximum != 0.0)
      range = shortest(signal.minimum) + " to " + shortest(signal.maximum);
    rows.push_back(
        {signal.name, std::to_string(signal.start_bit) + '|' + std::to_string(signal.length),
         signal.byte_order == can::ByteOrder::little_endian ? "little" : "big",
         std::string(type_name(signal.type)), shortest(signal.scale), shortest(signal.offset),
         range, signal.unit, multiplexing_text(message, signal), one_line(signal.comment)});
  }
  print_columns(rows);
}

void show(const std::string& file, OutputForm form) {
  const Database database = can::read_dbc(file);
  if (form == OutputForm::json) {
    std::cout << database_json(database).dump(2, ' ', false, ordered_json::error_handler_t::replace)
              << '\n';
    return;
  }
  std::size_t signals = 0;
  for (const Message& message : database.messages) signals += message.signals.size();
  std::cout << database.file << ": " << database.messages.size() << " messages, " << signals
            << " signals\n";
  for (const Message& message : database.messages) print_message(message);
  for (const auto& warning : database.warnings) std::cerr << describe(database, warning) << '\n';
}

// odom dbc decode ---------------------------------------------------------------------------------

/// Messages by identifier; of several databases the first that has it.
class MessageIndex {
 public:
  explicit MessageIndex(const std::vector<Database>& databases) {
    for (const Database& database : databases)
      for (const Message& message : database.messages)
        messages_.try_emplace(frame_key(message.id, message.format), &message);
  }

  [[nodiscard]] const Message* find(const Frame& frame) const {
    const auto found = messages_.find(frame_key(frame));
    return found == messages_.end() ? nullptr : found->second;
  }

 private:
  std::unordered_map<std::uint32_t, const Message*> messages_;
};

struct DecodedSignal {
  const Signal* signal = nullptr;
  double value = 0.0;
};

/// The signals that the payload holds: whose multiplexors select them, and which it does not cut.
std::vector<DecodedSignal> decoded_signals(const Message& message, const Frame& frame) {
  std::vector<DecodedSignal> decoded;
  for (const Signal& signal : message.signals) {
    const can::SignalLayout layout = can::layout_of(signal);
    if (frame.length < layout.bytes_needed || !is_present(message, signal, frame.payload()))
      continue;
    decoded.push_back({&signal, physical_value(layout, extract_bits(layout, frame.payload()))});
  }
  return decoded;
}

/// Seconds with 6 decimals, or 9 where the stamp has them: integers all the way.
std::string stamp_text(std::int64_t time_ns) {
  std::array<char, 32> text{};
  const long long seconds = time_ns / 1'000'000'000;
  const long long rest = time_ns % 1'000'000'000;
  if (rest % 1000 == 0)
    std::snprintf(text.data(), text.size(), "%lld.%06lld", seconds, rest / 1000);
  else
    std::snprintf(text.data(), text.size(), "%lld.%09lld", seconds, rest);
  return text.data();
}

std::string_view kind_name(can::FrameKind kind) {
  switch (kind) {
    case can::FrameKind::data:
      return "data";
    case can::FrameKind::remote:
      return "remote";
    case can::FrameKind::error:
      return "error";
  }
  return "";
}

std::string payload_text(const Frame& frame) {
  std::string text;
  for (const std::uint8_t byte : frame.payload()) {
    std::array<char, 3> digits{};
    std::snprintf(digits.data(), digits.size(), "%02X", unsigned{byte});
    text += digits.data();
  }
  return text;
}

std::string json_line(const Frame& frame, const std::string& bus, const Message* message) {
  std::string line = "{\"t\":" + stamp_text(frame.time_ns) + ",\"bus\":" + dumped(bus) +
                     ",\"id\":" + std::to_string(frame.id);
  if (frame.format == IdFormat::extended) line += ",\"extended\":true";
  line += ",\"message\":" + (message == nullptr ? "null" : dumped(message->name));
  ordered_json signals = ordered_json::object();
  if (message != nullptr)
    for (const auto& [signal, value] : decoded_signals(*message, frame))
      signals[signal->name] = value;
  line += ",\"signals\":" + dumped(signals);
  if (message == nullptr)
    line +=
        ",\"kind\":" + dumped(kind_name(frame.kind)) + ",\"data\":" + dumped(payload_text(frame));
  return line + "}\n";
}

/// The name that VAL_ gives to a value, if it does.
std::string value_name(const Signal& signal, double physical) {
  for (const auto& value : signal.values)
    if (static_cast<double>(value.raw) * signal.scale + signal.offset == physical)
      return " (" + value.name + ')';
  return {};
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
  for (const auto& [signal, value] : decoded_signals(*message, frame)) {
    line += "  " + signal->name + ' ' + shortest(value);
    if (!signal->unit.empty()) line += ' ' + signal->unit;
    line += value_name(*signal, value);
  }
  return line + '\n';
}

enum class Frames : std::uint8_t { known, all };

void decode(const std::vector<std::string>& files, const std::string& log, OutputForm form,
            Frames frames) {
  std::vector<Database> databases;
  for (const std::string& file : files) {
    databases.push_back(can::read_dbc(file));
    if (const std::size_t oddities = databases.back().warnings.size(); oddities > 0)
      std::cerr << file << ": " << oddities << (oddities == 1 ? " oddity" : " oddities")
                << " taken; odom dbc show " << file << " lists them\n";
  }
  const MessageIndex index(databases);
  can::BusNames buses;
  can::LogReader reader(log, buses);
  std::vector<std::string> bus_names;
  while (const auto frame = reader.next()) {
    const Message* message = frame->kind == can::FrameKind::data ? index.find(*frame) : nullptr;
    if (message == nullptr && frames == Frames::known) continue;
    if (frame->bus >= bus_names.size()) bus_names = buses.all();
    const std::string& bus = bus_names[frame->bus];
    std::cout << (form == OutputForm::json ? json_line(*frame, bus, message)
                                           : readable_line(*frame, bus, message));
    if (log == "-") std::cout.flush();  // a live source: lines as they come
  }
  if (!reader.warning().empty()) std::cerr << reader.warning() << '\n';
}

}  // namespace

void add_dbc(CLI::App& odom) {
  struct Options {
    std::string file;
    std::vector<std::string> databases;
    std::string log;
    bool json = false;
    bool all = false;
  };
  const auto options = std::make_shared<Options>();
  const auto form = [options] { return options->json ? OutputForm::json : OutputForm::readable; };

  CLI::App* dbc = odom.add_subcommand("dbc", "Look into CAN databases and decode logs by them");
  dbc->require_subcommand(1);

  CLI::App* show_command = dbc->add_subcommand("show", "Print the messages and signals of a DBC");
  show_command->add_option("FILE", options->file, "The database")->required();
  show_command->add_flag("--json", options->json, "One JSON object instead of tables");
  show_command->footer("Example: odom dbc show car.dbc");
  show_command->callback([options, form] { show(options->file, form()); });

  CLI::App* decode_command =
      dbc->add_subcommand("decode", "Decode a candump log, one line a frame");
  decode_command
      ->add_option("--dbc", options->databases,
                   "The database; of several the first that has an identifier decodes it")
      ->required()
      ->allow_extra_args(false);
  decode_command->add_option("LOG", options->log, "A log of candump -L, or - for standard input")
      ->required();
  decode_command->add_flag("--json", options->json, "One JSON object a line");
  decode_command->add_flag("--all", options->all, "Also frames that no database knows");
  decode_command->footer(
      "Examples: odom dbc decode --dbc car.dbc --json drive.log\n"
      "          candump -L can0 | odom dbc decode --dbc car.dbc -");
  decode_command->callback([options, form] {
    decode(options->databases, options->log, form(), options->all ? Frames::all : Frames::known);
  });
}

}  // namespace odomd::tools
