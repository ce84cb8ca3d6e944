// odom dbc: shows CAN databases and decodes logs with them.
#include <array>
#include <cstdint>

#include "can_protocol/bus_names.hpp"
#include "can_protocol/dbc/dbc.hpp"
#include "can_protocol/dbc/message_index.hpp"
#include "can_protocol/dbc/signal_layout.hpp"
#include "can_protocol/frame.hpp"
#include "can_protocol/sources/log_reader.hpp"
#include "tools/cli/csv.hpp"
#include "tools/commands/commands.hpp"
#include "tools/replay/log_options.hpp"

namespace odomd::tools {
namespace {

using can::Database;
using can::IdFormat;
using can::Message;
using can::Signal;
using nlohmann::ordered_json;

// As candump prints it: 3 digits, or 8 for an extended identifier.
std::string hexadecimal(std::uint32_t id, IdFormat format) {
  return format == IdFormat::extended ? fmt::format("{:08X}", id) : fmt::format("{:03X}", id);
}

std::string_view type_name(can::ValueType type) {
  constexpr std::array<std::string_view, 4> names{"unsigned", "signed", "float", "double"};
  return names[static_cast<std::size_t>(type)];
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
            << (message.id_mask == can::whole_id ? "" : "J1939, ")
            << counted(message.length, "byte")
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
std::vector<DecodedSignal> decoded_signals(const Message& message, const can::Frame& frame) {
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

/// Seconds with 6 decimals, or 9 if the stamp has them.
std::string stamp_text(std::int64_t time_ns) {
  std::string text;
  append_seconds(text, time_ns);
  return text.ends_with("000") ? text.substr(0, text.size() - 3) : text;
}

std::string json_line(const can::Frame& frame, const std::string& bus, const Message& message) {
  ordered_json signals = ordered_json::object();
  for (const auto& [signal, value, name] : decoded_signals(message, frame))
    signals[signal->name] = value;
  return fmt::format(R"({{"t":{},"bus":{},"id":{}{},"message":{},"signals":{}}})"
                     "\n",
                     stamp_text(frame.time_ns), json_text(bus), frame.id,
                     frame.format == IdFormat::extended ? R"(,"extended":true)" : "",
                     json_text(message.name), json_text(signals));
}

std::string readable_line(const can::Frame& frame, const std::string& bus, const Message& message) {
  std::string line = fmt::format("({}) {} {} {}", stamp_text(frame.time_ns), bus,
                                 hexadecimal(frame.id, frame.format), message.name);
  for (const auto& [signal, value, name] : decoded_signals(message, frame)) {
    line += "  " + signal->name + ' ' + shortest(value);
    if (!signal->unit.empty()) line += ' ' + signal->unit;
    if (!name.empty()) line.append(" (").append(name).append(")");
  }
  return line + '\n';
}

// Warnings go to standard error.
void show_dbc(const std::string& file) {
  const Database database = can::read_dbc(file);
  std::size_t signals = 0;
  for (const Message& message : database.messages) signals += message.signals.size();
  std::cout << database.file << ": " << database.messages.size() << " messages, " << signals
            << " signals\n";
  for (const Message& message : database.messages) print_message(message);
  for (const auto& warning : database.warnings) say(describe(database, warning));
}

// One line per known frame; of several databases, the first that has the identifier decodes it.
void decode_log(const std::vector<std::string>& databases, const std::string& log, bool json,
                can::Damage damage) {
  std::vector<Database> read;
  read.reserve(databases.size());
  for (const std::string& file : databases) read.push_back(can::read_dbc(file));
  const can::MessageIndex index(read);
  can::BusNames buses;
  can::LogReader reader(log, buses, damage);
  std::vector<std::string> bus_names;
  while (const auto* frame = reader.next()) {
    const Message* message = frame->kind == can::FrameKind::data ? index.find(*frame) : nullptr;
    if (message == nullptr) continue;
    if (frame->bus >= bus_names.size()) bus_names = buses.all();
    const std::string& bus = bus_names[frame->bus];
    std::cout << (json ? json_line(*frame, bus, *message) : readable_line(*frame, bus, *message));
    if (log == "-") std::cout.flush();  // a live source: flush each line
  }
  // Warnings come last, so that the error about an unusable file is the only line.
  for (const Database& database : read)
    if (const std::size_t warnings = database.warnings.size(); warnings > 0)
      say(fmt::format("{0}: {1}; odom dbc show {0} lists them", database.file,
                      counted(warnings, "warning")));
  for (const std::string& warning : reader.warnings()) say(warning);
}

}  // namespace

void add_dbc(Command odom) {
  struct Options {
    std::string file;
    std::vector<std::string> databases;
    std::string log;
    bool json = false;
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
  show_command.footer(
      "Example:\n"
      "  odom dbc show car.dbc");
  show_command.callback([options] { show_dbc(options->file); });

  Command decode_command = dbc.add_subcommand("decode", "Decode a candump log, one line per frame");
  decode_command.add("--dbc", "DBC", options->databases,
                     "Database (DBC); repeatable: the first that contains the identifier is used",
                     {required(), one_each()});
  decode_command.add("LOG", "", options->log, "Log of candump -L, or - for standard input",
                     {required()});
  decode_command.add_flag("--json", options->json, "Print each frame as JSON, one per line");
  add_strict(decode_command, options->damage);
  decode_command.footer(
      "Examples:\n"
      "  odom dbc decode --dbc car.dbc drive.log\n"
      "  odom dbc decode --dbc powertrain.dbc --dbc chassis.dbc --json drive.log\n"
      "  candump -L can0 | odom dbc decode --dbc car.dbc -");
  decode_command.callback(
      [options] { decode_log(options->databases, options->log, options->json, options->damage); });
}

}  // namespace odomd::tools
