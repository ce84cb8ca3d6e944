// The DBC parser: one function per statement. Internal to parse_dbc.
#pragma once

#include <cstdint>
#include <functional>
#include <map>
#include <optional>
#include <set>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "can_protocol/dbc/cursor.hpp"
#include "can_protocol/dbc/dbc.hpp"
#include "can_protocol/dbc/draft.hpp"

namespace odomd::can {

/// Reads one file; use once. References to messages and signals are applied at the end, since they
/// may come before the definitions.
class DbcParser {
 public:
  DbcParser(std::string_view text, std::string file_name);

  /// Throws DbcError if the file is cut off, or if nothing can be used.
  Database run();

 private:
  // parser.cpp: the statements that build messages.
  void statement();
  /// Leaves out the statement that began with `first`, after a mistake in it.
  void leave_out_statement(const Token& first, const DbcMistake& mistake);
  void ignore_message(const std::string& name, std::uint32_t line, std::string why);
  void version();
  void symbols();
  void pass_over_list();
  void message(std::uint32_t line);
  void signal(std::uint32_t line);
  void layout(Signal& signal, DraftSignal& draft);
  void multiplexing_of(Signal& signal, DraftSignal& draft);
  void order_and_sign(Signal& signal);
  void scaling(Signal& signal);
  void range(Signal& signal);
  std::optional<std::size_t> add_signal(Signal signal, DraftSignal draft);

  // references.cpp: the statements that refer to messages and signals.
  void comment();
  void value_table();
  void value_names();
  std::vector<ValueName> values(std::string_view form);
  void value_type();
  void extended_multiplexing();

  // attributes.cpp
  void attribute_definition();
  void attribute_default();
  void attribute();
  void message_cycle_time();
  void frame_format();
  void long_message_name();
  void long_signal_name();
  void long_node_name();

  static constexpr std::uint64_t extended_flag = 0x8000'0000U;
  /// Editors put signals without a message under this identifier.
  static constexpr std::uint64_t unused_signals_id = 0xC000'0000U;

  struct Identifier {
    std::uint32_t id = 0;
    IdFormat format = IdFormat::standard;
    bool flag_missing = false;
  };
  /// Bit 31 of the number marks an extended identifier. Empty if no frame can have the identifier.
  [[nodiscard]] static std::optional<Identifier> identifier_of(std::uint64_t number);
  /// Takes a whole number; returns 2^64 - 1, which no frame has, for a negative or too large one.
  std::uint64_t take_identifier(std::string_view what, std::string_view fix);
  /// The key in by_key_: frame_key, or the number itself if no frame can have it.
  [[nodiscard]] static std::uint64_t key_of(std::uint64_t number);

  struct Reference {
    std::uint32_t line = 0;
    std::string statement;
    std::uint64_t number = 0;
  };
  Reference reference(std::string statement);
  /// Reads the signal's name in a statement that defines the meaning of the signal's values. If
  /// there is a mistake in the rest of the statement, the signal is left out.
  std::string take_meaning(const Reference& of, std::string_view form);
  /// The message; null if it was ignored or, with a warning, if it is unknown.
  DraftMessage* find(const Reference& reference);
  /// Calls `apply(draft, index of the signal)` once everything is known.
  void with_signal(Reference reference, std::string name,
                   std::function<void(DraftMessage&, std::size_t)> apply);
  void message_comment(Reference of, std::string_view form);
  void set_multiplexor(DraftMessage& draft, std::size_t signal, std::uint32_t line,
                       const std::string& multiplexor, const std::vector<MultiplexRange>& ranges);
  double cycle_time();
  void apply_attributes(DraftMessage& draft) const;
  static void tell_groups_apart(std::vector<Message>& messages);

  DbcCursor cursor_;
  std::vector<DraftMessage> drafts_;
  DraftMessage* current_ =
      nullptr;  ///< the message to which signals are added; null: they are ignored
  bool inside_message_ = false;
  std::map<std::uint64_t, std::optional<std::size_t>> by_key_;  ///< empty: ignored
  std::vector<std::function<void()>> later_;
  /// The signal (in a BO_: the message) to leave out if the current statement has a mistake.
  std::optional<std::pair<Reference, std::string>> lost_signal_;
  std::string lost_message_;
  std::vector<LeftOut> left_out_;                               ///< messages
  std::map<std::string, std::vector<ValueName>> value_tables_;  ///< VAL_TABLE_
  std::set<std::string> names_;                                 ///< of the messages
  std::map<std::string, std::string> node_names_;               ///< short name to long name
  std::vector<std::string> frame_formats_;  ///< names for the numbers of VFrameFormat
  std::string default_frame_format_;
  bool is_j1939_ = false;  ///< according to ProtocolType
  double default_cycle_time_ms_ = 0.0;
};

}  // namespace odomd::can
