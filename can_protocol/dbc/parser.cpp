// DBC statements that define messages and signals, and those that are skipped.
#include "can_protocol/dbc/parser.hpp"

#include <algorithm>
#include <limits>
#include <utility>

#include "base/printable.hpp"
#include "can_protocol/dbc/signal_layout.hpp"

namespace odomd::can {
namespace {

constexpr std::uint32_t largest_standard_id = 0x7FFU;
constexpr std::uint32_t largest_extended_id = 0x1FFF'FFFFU;
constexpr std::uint64_t largest_u64 = std::numeric_limits<std::uint64_t>::max();

/// Limit of the search for overlapping signals, a fraction of a second; real databases need less.
constexpr std::size_t comparisons = std::size_t{1} << 25U;

constexpr std::string_view signal_form =
    "write SG_ NAME : START|LENGTH@ORDER+ (FACTOR,OFFSET) [MIN|MAX] \"UNIT\" RECEIVER";
constexpr std::string_view message_form = "write BO_ ID NAME: LENGTH SENDER";

}  // namespace

Database parse_dbc(std::string_view text, std::string file_name) {
  return DbcParser(text, std::move(file_name)).run();
}

DbcParser::DbcParser(std::string_view text, std::string file_name)
    : cursor_(text, std::move(file_name)), by_key_{{unused_signals_id, std::nullopt}} {}

Database DbcParser::run() {
  std::optional<DbcMistake> first_mistake;
  while (!cursor_.at_end()) {
    const Token first = cursor_.peek();
    cursor_.concern(no_message);
    lost_signal_.reset();
    lost_message_.clear();
    try {
      statement();
    } catch (const DbcMistake& mistake) {
      if (cursor_.at_end()) throw;  // the file is cut off: what is missing is unknown
      if (!first_mistake) first_mistake.emplace(mistake);
      leave_out_statement(first, mistake);
      cursor_.skip_to_statement();
    }
  }
  cursor_.concern(std::nullopt);
  cursor_.check_ending();
  if (drafts_.empty() && first_mistake) throw DbcError(*first_mistake);
  for (const auto& apply : later_) apply();
  Database database;
  Effort effort(comparisons);
  for (DraftMessage& draft : drafts_) {
    cursor_.concern(frame_key(draft.message.id, draft.message.format));
    apply_attributes(draft);
    resolve_signals(draft, cursor_);
    warn_of_overlaps(draft.message, effort, cursor_);
    database.messages.push_back(std::move(draft.message));
  }
  tell_groups_apart(database.messages);
  cursor_.concern(std::nullopt);
  if (!effort.spend(1))
    cursor_.warn(1, "too many signals to compare them all; some may overlap without a warning");
  database.file = cursor_.file_name();
  database.left_out = std::move(left_out_);
  database.warnings = cursor_.take_warnings();
  return database;
}

void DbcParser::leave_out_statement(const Token& first, const DbcMistake& mistake) {
  if (lost_signal_)
    return with_signal(
        std::move(lost_signal_->first), std::move(lost_signal_->second),
        [this, line = mistake.line, text = mistake.text](DraftMessage& draft, std::size_t i) {
          leave_out(draft, i, line, text, cursor_);
        });
  // An unreadable statement may have been a BO_, so the message of the signals below is unknown.
  if (first.text == "BO_" || !is_dbc_keyword(first.text)) {
    current_ = nullptr;
    inside_message_ = true;
  }
  if (lost_message_.empty())
    cursor_.warn_left_out(mistake.line, mistake.text + "; left out");
  else
    ignore_message(lost_message_, mistake.line,
                   mistake.text + "; message '" + lost_message_ + "' left out");
}

void DbcParser::ignore_message(const std::string& name, std::uint32_t line, std::string why) {
  cursor_.warn_left_out(line, why);
  left_out_.push_back({name, line, std::move(why)});
}

void DbcParser::statement() {
  if (cursor_.take_if(';')) return;
  const Token token = cursor_.peek();
  const std::string& keyword = token.text;
  if (token.kind == TokenKind::word) {
    cursor_.take();
    if (keyword == "BO_") return message(token.line);
    if (keyword == "SG_") return signal(token.line);
    if (keyword == "CM_") return comment();
    if (keyword == "VAL_TABLE_") return value_table();
    if (keyword == "VAL_") return value_names();
    if (keyword == "BA_") return attribute();
    if (keyword == "BA_DEF_") return attribute_definition();
    if (keyword == "BA_DEF_DEF_") return attribute_default();
    if (keyword == "SIG_VALTYPE_") return value_type();
    if (keyword == "SG_MUL_VAL_") return extended_multiplexing();
    if (keyword == "VERSION") return version();
    if (keyword == "NS_") return symbols();
    if (keyword == "BS_" || keyword == "BU_") return pass_over_list();
    if (is_dbc_keyword(keyword)) return cursor_.skip_statement(keyword);
    // Extensions of other tools look like this; so does a misspelt BO_, but that has no ';'.
    if (keyword.size() > 1 && keyword.ends_with('_')) {
      cursor_.skip_to_end();
      if (cursor_.take_if(';')) return;
    }
  }
  cursor_.fail(token, "a statement such as BO_, SG_, CM_ or VAL_",
               "remove it, or fix the statement before it");
}

// Statements that are skipped

void DbcParser::version() {
  cursor_.take_text("the version in quotes", "write VERSION \"\"");
  cursor_.take_if(';');
}

/// Skips the symbols that the file may use, mostly one per line; they look like statements.
void DbcParser::symbols() {
  cursor_.take_punctuation(':', "after NS_", "write NS_ :");
  while (cursor_.peek().kind == TokenKind::word) {
    const bool alone = cursor_.peek(1).starts_line || cursor_.peek(1).kind == TokenKind::end;
    if (cursor_.peek().starts_line && !alone) return;
    cursor_.take();
  }
}

/// Skips BS_: and BU_:, which do not end with a ';'.
void DbcParser::pass_over_list() {
  cursor_.take_punctuation(':', "after BS_ or BU_", "write BS_: or BU_: NODE ...");
  while (!cursor_.at_end() && !cursor_.at_statement()) cursor_.take();
}

// Messages and signals

std::optional<DbcParser::Identifier> DbcParser::identifier_of(std::uint64_t number) {
  const std::uint64_t id = number & ~extended_flag;
  if (id > largest_extended_id) return std::nullopt;
  const bool flagged = id != number;
  const bool extended = flagged || id > largest_standard_id;
  return Identifier{static_cast<std::uint32_t>(id),
                    extended ? IdFormat::extended : IdFormat::standard, extended && !flagged};
}

std::uint64_t DbcParser::take_identifier(std::string_view what, std::string_view fix) {
  const Token& token = cursor_.peek();
  std::string_view digits = token.text;
  if (digits.starts_with('-')) digits.remove_prefix(1);
  const bool impossible = token.kind == TokenKind::word && !unsigned_of(token.text) &&
                          !digits.empty() &&
                          digits.find_first_not_of("0123456789") == std::string_view::npos;
  if (!impossible) return cursor_.take_unsigned(what, largest_u64, fix);
  cursor_.take();
  return largest_u64;
}

std::uint64_t DbcParser::key_of(std::uint64_t number) {
  const auto identifier = identifier_of(number);
  return identifier ? frame_key(identifier->id, identifier->format) : number;
}

void DbcParser::message(std::uint32_t line) {
  DraftMessage draft;
  Message& message = draft.message;
  const std::string number_text = cursor_.peek().text;
  const std::uint64_t number = take_identifier("the message's identifier", message_form);
  const auto [place, first] = by_key_.try_emplace(key_of(number), std::optional<std::size_t>{});
  cursor_.concern(key_of(number));
  message.name = cursor_.take_name("the message's name", message_form);
  lost_message_ = message.name;
  cursor_.take_punctuation(':', "after the message's name", message_form);
  const std::uint64_t length =
      cursor_.take_unsigned("the message's length in bytes", 0xFFFF, message_form);
  if (cursor_.peek().kind == TokenKind::word && !cursor_.peek().starts_line)
    message.sender = cursor_.take().text;
  message.line = line;

  current_ = nullptr;
  inside_message_ = true;
  if (number == unused_signals_id) return;  // its signals are ignored
  const auto identifier = identifier_of(number);
  if (!identifier)
    return ignore_message(
        message.name, line,
        "no frame has the identifier " + shortened(number_text, 40) + " of message '" +
            message.name +
            "'; ignored. Write its 11 or 29 bits, plus 2147483648 if it is extended");
  if (identifier->flag_missing)
    cursor_.warn(line, "identifier " + number_text + " of message '" + message.name +
                           "' has more than 11 bits but no extended flag; treated as extended");
  message.id = identifier->id;
  message.format = identifier->format;
  if (!first)
    return ignore_message(
        message.name, line,
        "message '" + message.name + "' has the identifier of another one above; ignored");
  if (length > max_payload)
    return ignore_message(message.name, line,
                          "message '" + message.name + "' has " + std::to_string(length) +
                              " bytes, more than a frame; ignored");
  if (!names_.insert(message.name).second)
    cursor_.warn(line, "message '" + message.name +
                           "' has the name of another one above, "
                           "which is the one found by name");
  message.length = static_cast<std::uint8_t>(length);
  place->second = drafts_.size();
  current_ = &drafts_.emplace_back(std::move(draft));
}

void DbcParser::signal(std::uint32_t line) {
  if (!inside_message_)
    cursor_.fail(cursor_.peek(), "a message (BO_) before the first signal",
                 "put the signal below its BO_");
  if (current_ == nullptr) return cursor_.skip_to_statement();
  cursor_.concern(frame_key(current_->message.id, current_->message.format));
  Signal signal;
  DraftSignal draft;
  signal.line = line;
  signal.name = cursor_.take_name("the signal's name", signal_form);
  try {
    layout(signal, draft);
  } catch (const DbcMistake& mistake) {
    if (cursor_.at_end()) throw;
    cursor_.skip_to_statement();
    if (const auto index = add_signal(std::move(signal), std::move(draft)))
      leave_out(*current_, *index, mistake.line, mistake.text, cursor_);
    return;
  }
  while ((cursor_.peek().kind == TokenKind::word && !cursor_.at_statement()) ||
         cursor_.at_punctuation(','))
    cursor_.take();  // receivers
  if (signal.scale == 0.0) cursor_.warn(line, "signal '" + signal.name + "' has the factor 0");
  add_signal(std::move(signal), std::move(draft));
}

void DbcParser::layout(Signal& signal, DraftSignal& draft) {
  if (!cursor_.at_punctuation(':')) multiplexing_of(signal, draft);
  cursor_.take_punctuation(':', "after the signal's name", signal_form);
  const Token start = cursor_.peek();
  const std::uint64_t start_bit =
      cursor_.take_unsigned("the signal's start bit", max_payload * 8 - 1, signal_form);
  cursor_.take_punctuation('|', "after the start bit", signal_form);
  signal.length = static_cast<std::uint8_t>(cursor_.take_unsigned(
      "the signal's length in bits, 1 to 64", 64, "longer ones cannot be used"));
  if (signal.length == 0)
    cursor_.fail_at(signal.line, "expected the length of signal '" + signal.name +
                                     "', 1 to 64 bits, found 0; fix or remove the signal");
  cursor_.take_punctuation('@', "after the signal's length", signal_form);
  order_and_sign(signal);
  if (bytes_needed(static_cast<unsigned>(start_bit), signal.length, signal.byte_order) >
      max_payload)
    cursor_.fail(start, "a start bit from which signal '" + signal.name + "' fits 64 bytes",
                 "fix its start bit or its length");
  signal.start_bit = static_cast<std::uint16_t>(start_bit);
  scaling(signal);
  range(signal);
  signal.unit = cursor_.take_line("the signal's unit in quotes", signal_form);
}

/// M, m3 or m3M; m or mM if SG_MUL_VAL_ gives the value.
void DbcParser::multiplexing_of(Signal& signal, DraftSignal& draft) {
  const Token token = cursor_.peek();
  std::string_view word = token.text;
  if (word.ends_with('M')) {
    signal.is_multiplexor = true;
    word.remove_suffix(1);
  }
  if (word.starts_with('m')) {
    draft.marked = true;
    draft.selected_by = unsigned_of(word.substr(1));
    if (draft.selected_by || word == "m") word = {};
  }
  if (token.kind != TokenKind::word || !word.empty())
    cursor_.fail(token, "':' or a multiplexing (M, m0, m0M) after the signal's name", signal_form);
  cursor_.take();
}

void DbcParser::order_and_sign(Signal& signal) {
  const Token token = cursor_.peek();
  std::string word = cursor_.take_word("the byte order, 0 or 1", signal_form);
  if (word.size() == 1 && cursor_.peek().kind == TokenKind::word) word += cursor_.take().text;
  if (word.size() != 2 || (word[0] != '0' && word[0] != '1') || (word[1] != '+' && word[1] != '-'))
    cursor_.fail(token, "byte order and sign, one of 1+ 1- 0+ 0-", signal_form);
  signal.byte_order = word[0] == '1' ? ByteOrder::little_endian : ByteOrder::big_endian;
  signal.type = word[1] == '-' ? ValueType::signed_integer : ValueType::unsigned_integer;
}

void DbcParser::scaling(Signal& signal) {
  cursor_.take_punctuation('(', "before the factor", signal_form);
  signal.scale = cursor_.take_number("the signal's factor", signal_form);
  cursor_.take_punctuation(',', "between factor and offset", signal_form);
  signal.offset = cursor_.take_number("the signal's offset", signal_form);
  cursor_.take_punctuation(')', "after the offset", signal_form);
}

/// Nothing depends on the range, so a mistake in it leaves out the range only.
void DbcParser::range(Signal& signal) {
  cursor_.take_punctuation('[', "before the range", signal_form);
  try {
    const double minimum = cursor_.take_number("the signal's minimum", signal_form);
    cursor_.take_punctuation('|', "between minimum and maximum", signal_form);
    signal.maximum = cursor_.take_number("the signal's maximum", signal_form);
    signal.minimum = minimum;
  } catch (const DbcMistake& mistake) {
    if (cursor_.at_end()) throw;
    cursor_.warn_left_out(mistake.line, "expected a range of numbers, found " +
                                            show(cursor_.peek()) + "; the range of signal '" +
                                            signal.name + "' left out");
    while (!cursor_.at_end() && !cursor_.at_punctuation(']') && !cursor_.peek().starts_line)
      cursor_.take();
  }
  cursor_.take_punctuation(']', "after the range", signal_form);
}

std::optional<std::size_t> DbcParser::add_signal(Signal signal, DraftSignal draft) {
  const std::size_t index = current_->message.signals.size();
  if (!current_->by_name.try_emplace(signal.name, index).second) {
    cursor_.warn(signal.line, "message '" + current_->message.name + "' has two signals '" +
                                  signal.name + "'; the first one is used");
    return std::nullopt;
  }
  current_->message.signals.push_back(std::move(signal));
  current_->signals.push_back(std::move(draft));
  return index;
}

}  // namespace odomd::can
