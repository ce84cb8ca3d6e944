// DBC statements that refer to messages and signals: comments, names of values, floating-point
// types, extended multiplexing.
#include <cmath>
#include <utility>

#include "can_protocol/dbc/parser.hpp"

namespace odomd::can {
namespace {

constexpr std::string_view id_form = "write the number that stands after BO_";

}  // namespace

DbcParser::Reference DbcParser::reference(std::string statement) {
  const std::uint32_t line = cursor_.peek().line;
  const std::uint64_t number = take_identifier("the identifier of a message", id_form);
  cursor_.concern(key_of(number));
  return {line, std::move(statement), number};
}

std::string DbcParser::take_meaning(const Reference& of, std::string_view form) {
  std::string name = cursor_.take_word("the signal's name", form);
  lost_signal_.emplace(of, name);
  return name;
}

DraftMessage* DbcParser::find(const Reference& reference) {
  cursor_.concern(key_of(reference.number));
  const auto found = by_key_.find(key_of(reference.number));
  if (found == by_key_.end()) {
    cursor_.warn(reference.line, reference.statement + " names message " +
                                     std::to_string(reference.number) +
                                     ", which is not in the file; ignored");
    return nullptr;
  }
  return found->second ? &drafts_[*found->second] : nullptr;
}

void DbcParser::with_signal(Reference reference, std::string name,
                            std::function<void(DraftMessage&, std::size_t)> apply) {
  later_.emplace_back(
      [this, reference = std::move(reference), name = std::move(name), apply = std::move(apply)] {
        DraftMessage* draft = find(reference);
        if (draft == nullptr) return;
        const auto signal = find_signal(*draft, name);
        if (!signal)
          cursor_.warn(reference.line, reference.statement + " names signal '" + name +
                                           "', which message '" + draft->message.name +
                                           "' does not have; ignored");
        else
          apply(*draft, *signal);
      });
}

void DbcParser::comment() {
  constexpr std::string_view form = "write CM_ SG_ ID SIGNAL \"text\";";
  const Token kind = cursor_.peek();
  if (kind.text == "BO_" && kind.kind == TokenKind::word) {
    cursor_.take();
    message_comment(reference("CM_ BO_"), form);
  } else if (kind.text == "SG_" && kind.kind == TokenKind::word) {
    cursor_.take();
    Reference of = reference("CM_ SG_");
    if (cursor_.peek().kind == TokenKind::text) {
      cursor_.warn(of.line, "CM_ SG_ names no signal; treated as the comment of the message");
      message_comment(std::move(of), form);
    } else {
      std::string name = cursor_.take_word("the signal's name", form);
      std::string text = cursor_.take_text("the comment in quotes", form);
      with_signal(std::move(of), std::move(name), [text](DraftMessage& draft, std::size_t i) {
        draft.message.signals[i].comment = text;
      });
    }
  } else {
    return cursor_.skip_statement("CM_");
  }
  cursor_.end_statement("CM_");
}

void DbcParser::message_comment(Reference of, std::string_view form) {
  std::string text = cursor_.take_text("the comment in quotes", form);
  later_.emplace_back([this, of = std::move(of), text = std::move(text)] {
    if (DraftMessage* draft = find(of)) draft->message.comment = text;
  });
}

void DbcParser::value_table() {
  const std::string name = cursor_.peek().text;
  if (cursor_.peek().kind == TokenKind::word) cursor_.take();
  value_tables_[name] = values(R"(write VAL_TABLE_ NAME 0 "name" 1 "name" ;)");
  cursor_.end_statement("VAL_TABLE_");
}

void DbcParser::value_names() {
  constexpr std::string_view form = R"(write VAL_ ID SIGNAL 0 "name" 1 "name" ;)";
  if (!unsigned_of(cursor_.peek().text))  // belongs to an environment variable
    return cursor_.skip_statement("VAL_");
  Reference of = reference("VAL_");
  std::string name = cursor_.take_word("the signal's name", form);
  const Token table = cursor_.peek();
  std::function<void(DraftMessage&, std::size_t)> apply;
  if (table.kind == TokenKind::word && value_tables_.contains(table.text)) {
    cursor_.take();
    cursor_.warn(table.line, "VAL_ of signal '" + name + "' names " + show(table) +
                                 " instead of values; taken from that VAL_TABLE_");
    apply = [this, table = table.text](DraftMessage& draft, std::size_t i) {
      draft.message.signals[i].values = value_tables_.at(table);
    };
  } else {
    apply = [values = values(form)](DraftMessage& draft, std::size_t i) {
      draft.message.signals[i].values = values;
    };
  }
  cursor_.end_statement("VAL_");
  with_signal(std::move(of), std::move(name), std::move(apply));
}

std::vector<ValueName> DbcParser::values(std::string_view form) {
  std::vector<ValueName> values;
  while (cursor_.peek().kind == TokenKind::word && !cursor_.at_statement()) {
    const Token token = cursor_.peek();
    const double raw = cursor_.take_number("a raw value", form);
    std::string text = cursor_.take_line("the value's name in quotes", form);
    // 2^63 as a double: raw values are smaller.
    if (raw != std::nearbyint(raw) || std::abs(raw) >= 9223372036854775808.0)
      cursor_.warn(token.line, "VAL_ names " + show(token) + ", which is not a raw value");
    else
      values.push_back({static_cast<std::int64_t>(raw), std::move(text)});
  }
  return values;
}

void DbcParser::value_type() {
  constexpr std::string_view form = "write SIG_VALTYPE_ ID SIGNAL : 1;";
  Reference of = reference("SIG_VALTYPE_");
  std::string name = take_meaning(of, form);
  cursor_.take_if(':');
  const std::uint64_t type = cursor_.take_unsigned("0 (integer), 1 (float) or 2 (double)", 2, form);
  cursor_.end_statement("SIG_VALTYPE_");
  if (type == 0) return;
  const std::uint32_t line = of.line;
  with_signal(
      std::move(of), std::move(name), [this, type, line](DraftMessage& draft, std::size_t i) {
        Signal& signal = draft.message.signals[i];
        const unsigned length = type == 1 ? 32 : 64;
        if (signal.length != length)
          return leave_out(draft, i, line,
                           "expected " + std::to_string(length) +
                               " bits for the floating-point signal '" + signal.name + "', found " +
                               std::to_string(signal.length) + "; fix its SG_ or SIG_VALTYPE_",
                           cursor_);
        signal.type = type == 1 ? ValueType::float32 : ValueType::float64;
      });
}

void DbcParser::extended_multiplexing() {
  constexpr std::string_view form = "write SG_MUL_VAL_ ID SIGNAL MULTIPLEXOR 0-0, 2-5;";
  Reference of = reference("SG_MUL_VAL_");
  std::string name = take_meaning(of, form);
  const Token multiplexor = cursor_.peek();
  cursor_.take_word("the multiplexor's name", form);
  std::vector<MultiplexRange> ranges;
  do {
    const Token token = cursor_.peek();
    const std::string word = cursor_.take_word("a range of multiplexor values", form);
    const std::size_t dash = word.find('-');
    const auto first = unsigned_of(std::string_view{word}.substr(0, dash));
    const auto last =
        dash == std::string::npos ? first : unsigned_of(std::string_view{word}.substr(dash + 1));
    if (!first || !last || *first > *last)
      cursor_.fail(token, "a range of multiplexor values", form);
    ranges.push_back({*first, *last});
  } while (cursor_.take_if(','));
  cursor_.end_statement("SG_MUL_VAL_");
  const std::uint32_t line = of.line;
  with_signal(
      std::move(of), std::move(name),
      [this, line, multiplexor = multiplexor.text, ranges](DraftMessage& draft, std::size_t i) {
        set_multiplexor(draft, i, line, multiplexor, ranges);
      });
}

void DbcParser::set_multiplexor(DraftMessage& draft, std::size_t signal, std::uint32_t line,
                                const std::string& multiplexor,
                                const std::vector<MultiplexRange>& ranges) {
  DraftSignal& written = draft.signals[signal];
  auto& signals = draft.message.signals;
  const auto found = find_signal(draft, multiplexor);
  if (!found || (!written.multiplexor.empty() && written.multiplexor != multiplexor))
    return leave_out(draft, signal, line,
                     "expected the one multiplexor of signal '" + signals[signal].name +
                         "', found '" + multiplexor + "'; name a signal of message '" +
                         draft.message.name + "'",
                     cursor_);
  if (!signals[*found].is_multiplexor) {
    cursor_.warn(line, "signal '" + multiplexor +
                           "' is not marked as a multiplexor (M); treated "
                           "as one");
    signals[*found].is_multiplexor = true;
  }
  written.multiplexor = multiplexor;
  written.ranges.insert(written.ranges.end(), ranges.begin(), ranges.end());
}

}  // namespace odomd::can
