// The CAN database: messages and signals as a DBC file describes them. Read at start only; the
// tables that decode frames are compiled from it (signal_layout.hpp, ../decode/decoder.hpp).
#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <optional>
#include <stdexcept>
#include <string>
#include <string_view>
#include <vector>

#include "can_protocol/frame.hpp"

namespace odomd::can {

enum class ByteOrder : std::uint8_t { little_endian, big_endian };  // Intel, Motorola
enum class ValueType : std::uint8_t { unsigned_integer, signed_integer, float32, float64 };

/// A name for one raw value (VAL_).
struct ValueName {
  std::int64_t raw = 0;
  std::string name;
};

/// Raw values of a multiplexor, both ends included.
struct MultiplexRange {
  std::uint64_t first = 0;
  std::uint64_t last = 0;
};

struct Signal {
  std::string name;
  std::string short_name;  ///< name in its SG_, if `name` is a long one (SystemSignalLongSymbol)
  /// As in the file: bit `start_bit % 8` of byte `start_bit / 8`; the least significant bit of a
  /// little-endian signal, the most significant bit of a big-endian one.
  std::uint16_t start_bit = 0;
  std::uint8_t length = 0;  ///< bits, 1 to 64
  ByteOrder byte_order = ByteOrder::little_endian;
  ValueType type = ValueType::unsigned_integer;
  double scale = 1.0;  ///< physical = raw * scale + offset
  double offset = 0.0;
  double minimum = 0.0;  ///< as in the file; both 0: not given
  double maximum = 0.0;
  std::string unit;
  std::string comment;
  std::vector<ValueName> values;  ///< in the file's order

  bool is_multiplexor = false;
  /// For a multiplexed signal: its multiplexor's index in Message::signals, and those raw values of
  /// the multiplexor that select it (may be empty). The multiplexor may be multiplexed, too.
  std::optional<std::size_t> multiplexor;
  std::vector<MultiplexRange> selected_by;

  std::uint32_t line = 0;  ///< of its SG_
};

/// A message or signal of the file that cannot be used.
struct LeftOut {
  std::string name;
  std::uint32_t line = 0;
  std::string why;  ///< the text of its warning
};

struct Message {
  std::string name;
  std::string short_name;  ///< name in its BO_, if `name` is a long one (SystemMessageLongSymbol)
  std::uint32_t id = 0;    ///< without flags
  /// The bits of `id` that a frame must match. For J1939 the bits of the group, and those of the
  /// addresses if the file has several messages of it.
  std::uint32_t id_mask = whole_id;
  IdFormat format = IdFormat::standard;
  FrameProtocol protocol = FrameProtocol::classic;
  std::uint8_t length = 0;  ///< payload bytes, 0 to max_payload
  std::string sender;
  std::string comment;
  std::int64_t cycle_time_ns = 0;  ///< GenMsgCycleTime; 0: none
  std::vector<Signal> signals;     ///< in the file's order
  std::vector<LeftOut> left_out;   ///< signals
  std::uint32_t line = 0;          ///< of its BO_
};

/// An irregularity that was accepted because its meaning is clear, or something that is left out.
struct Warning {
  std::uint32_t line = 0;
  std::string text;
  std::optional<std::uint64_t> message;  ///< frame_key of the message concerned; empty: the file
};

struct Database {
  std::string file;
  std::vector<Message> messages;  ///< in the file's order; identifiers are unique
  std::vector<LeftOut> left_out;  ///< messages
  std::vector<Warning> warnings;  ///< by line
};

/// The file is not a DBC, or it is cut off: "file:line: expected X, found Y; fix".
class DbcError : public std::invalid_argument {
 public:
  using std::invalid_argument::invalid_argument;
};

/// Reads the text of a DBC (UTF-8, or Windows-1252 as a superset of Latin-1; names and texts come
/// out in UTF-8). `file_name` is for messages. Throws DbcError.
[[nodiscard]] Database parse_dbc(std::string_view text, std::string file_name);

/// Reads a file. Throws DbcError, also when it cannot be read.
[[nodiscard]] Database read_dbc(const std::filesystem::path& file);

/// "file:line: text", as shown to the user.
[[nodiscard]] std::string describe(const Database& database, const Warning& warning);

/// The message or signal with this name, otherwise with this short name; the first of several, null
/// if there is none.
[[nodiscard]] const Message* find_message(const Database& database, std::string_view name);
[[nodiscard]] const Signal* find_signal(const Message& message, std::string_view name);

}  // namespace odomd::can
