// DBC attributes: the cycle time in milliseconds, the frame format, J1939, and long names.
#include <algorithm>
#include <array>
#include <cmath>
#include <string>
#include <string_view>
#include <utility>

#include "can_protocol/dbc/parser.hpp"

namespace odomd::can {
namespace {

constexpr std::string_view long_name_form =
    R"(write BA_ "SystemSignalLongSymbol" SG_ ID SIGNAL "NAME";)";

/// The ProtocolType of J1939; the VFrameFormat "J1939PG" begins with it.
constexpr std::string_view j1939 = "J1939";

template <typename Named>
void give_long_name(Named& named, const std::string& name) {
  if (named.short_name.empty()) named.short_name = named.name;
  named.name = name;
}

}  // namespace

void DbcParser::attribute_definition() {
  while (!cursor_.at_end() && cursor_.peek().kind == TokenKind::word) cursor_.take();
  if (cursor_.peek().text == "VFrameFormat") {
    cursor_.take();
    while (!cursor_.at_end() && !cursor_.at_punctuation(';') && !cursor_.at_statement()) {
      const Token& token = cursor_.take();
      if (token.kind == TokenKind::text) frame_formats_.push_back(token.text);
    }
  }
  cursor_.skip_statement("BA_DEF_");
}

void DbcParser::attribute_default() {
  const std::string name = cursor_.peek().text;
  if (cursor_.peek(1).kind != TokenKind::end) {
    if (name == "GenMsgCycleTime") {
      cursor_.take();
      default_cycle_time_ms_ = cycle_time();
    } else if (name == "VFrameFormat") {
      cursor_.take();
      default_frame_format_ = cursor_.take().text;
    } else if (name == "ProtocolType") {
      cursor_.take();
      is_j1939_ = cursor_.take().text == j1939;
    }
  }
  cursor_.skip_statement("BA_DEF_DEF_");
}

void DbcParser::attribute() {
  const std::string name = cursor_.peek().text;
  if (name == "ProtocolType" && cursor_.peek(1).kind == TokenKind::text)
    is_j1939_ = cursor_.peek(1).text == j1939;
  const std::string object =
      cursor_.peek(1).kind == TokenKind::word ? cursor_.peek(1).text : std::string{};
  struct Known {
    std::string_view name;
    std::string_view object;
    void (DbcParser::*take)();
  };
  static constexpr std::array all{
      Known{"GenMsgCycleTime", "BO_", &DbcParser::message_cycle_time},
      Known{"VFrameFormat", "BO_", &DbcParser::frame_format},
      Known{"SystemMessageLongSymbol", "BO_", &DbcParser::long_message_name},
      Known{"SystemSignalLongSymbol", "SG_", &DbcParser::long_signal_name},
      Known{"SystemNodeLongSymbol", "BU_", &DbcParser::long_node_name}};
  const auto* const known = std::ranges::find_if(
      all, [&](const Known& other) { return other.name == name && other.object == object; });
  if (known == all.end()) return cursor_.skip_statement("BA_");
  cursor_.take();
  cursor_.take();
  (this->*known->take)();
  cursor_.end_statement("BA_");
}

void DbcParser::message_cycle_time() {
  const Reference of = reference("BA_ \"GenMsgCycleTime\"");
  later_.emplace_back([this, of, ms = cycle_time()] {
    if (DraftMessage* draft = find(of)) draft->cycle_time_ms = ms;
  });
}

void DbcParser::frame_format() {
  const Reference of = reference("BA_ \"VFrameFormat\"");
  const std::string word = cursor_.take().text;
  later_.emplace_back([this, of, index = unsigned_of(word), word] {
    if (DraftMessage* draft = find(of))
      draft->frame_format = index && *index < frame_formats_.size() ? frame_formats_[*index] : word;
  });
}

double DbcParser::cycle_time() {
  const Token token = cursor_.peek();
  const double ms = cursor_.take_number("the cycle time in milliseconds",
                                        "write BA_ \"GenMsgCycleTime\" BO_ ID MILLISECONDS;");
  constexpr double longest_ms = 1e9;
  if (ms >= 0.0 && ms <= longest_ms) return ms;
  cursor_.warn(token.line, "no message has a cycle time of " + show(token) + " ms; ignored");
  return 0.0;
}

void DbcParser::apply_attributes(DraftMessage& draft) const {
  if (const auto node = node_names_.find(draft.message.sender); node != node_names_.end())
    draft.message.sender = node->second;
  const double ms = draft.cycle_time_ms.value_or(default_cycle_time_ms_);
  draft.message.cycle_time_ns = std::llround(ms * 1e6);
  const std::string& format = draft.frame_format ? *draft.frame_format : default_frame_format_;
  const bool fd = draft.message.length > 8 || format.ends_with("CAN_FD");
  draft.message.protocol = fd ? FrameProtocol::fd : FrameProtocol::classic;
  if (draft.message.format == IdFormat::extended &&
      (format.starts_with(j1939) || (is_j1939_ && !draft.frame_format)))
    draft.message.id_mask = j1939_group_mask(draft.message.id);
}

/// If the file has several messages of one J1939 group, frames must match their addresses, too.
void DbcParser::tell_groups_apart(std::vector<Message>& messages) {
  std::map<std::pair<std::uint32_t, std::uint32_t>, int> count;  // by mask and masked identifier
  const auto key = [](const Message& message, std::uint32_t mask) {
    return std::pair{mask, message.id & mask};
  };
  for (const Message& message : messages)
    if (message.format == IdFormat::extended)
      for (const std::uint32_t mask : {j1939_group_mask(message.id), id_without_priority})
        ++count[key(message, mask)];
  constexpr std::uint32_t sender = 0xFF, nobody = 0xFE;  // the null address stands for any sender
  for (Message& message : messages)
    for (const std::uint32_t mask : {id_without_priority, whole_id})
      if (message.id_mask != whole_id && count[key(message, message.id_mask)] > 1)
        message.id_mask = (message.id & sender) == nobody ? id_without_priority & ~sender : mask;
}

// Long names: editors write names of more than 32 characters as attributes, and shortened ones
// everywhere else.

void DbcParser::long_message_name() {
  const Reference of = reference("BA_ \"SystemMessageLongSymbol\"");
  later_.emplace_back([this, of, name = cursor_.take_long_name()] {
    DraftMessage* draft = find(of);
    if (draft == nullptr || name.empty() || name == draft->message.name) return;
    if (!names_.insert(name).second)
      return cursor_.warn(of.line, "another message has the long name '" + name + "' of message '" +
                                       draft->message.name + "'; ignored");
    give_long_name(draft->message, name);
  });
}

void DbcParser::long_signal_name() {
  Reference of = reference("BA_ \"SystemSignalLongSymbol\"");
  std::string short_name = cursor_.take_word("the signal's name", long_name_form);
  const std::uint32_t line = of.line;
  with_signal(std::move(of), std::move(short_name),
              [this, line, name = cursor_.take_long_name()](DraftMessage& draft, std::size_t i) {
                Signal& signal = draft.message.signals[i];
                if (name.empty() || name == signal.name) return;
                if (!draft.by_name.try_emplace(name, i).second)
                  return cursor_.warn(line, "another signal of message '" + draft.message.name +
                                                "' has the long name '" + name + "' of signal '" +
                                                signal.name + "'; ignored");
                give_long_name(signal, name);
              });
}

void DbcParser::long_node_name() {
  std::string short_name = cursor_.take_word("the node's name", long_name_form);
  std::string name = cursor_.take_long_name();
  if (!name.empty()) node_names_.insert_or_assign(std::move(short_name), std::move(name));
}

}  // namespace odomd::can
