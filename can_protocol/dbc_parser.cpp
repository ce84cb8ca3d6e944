// The DBC parser: one function a statement. What refers to a message or a signal is kept and
// applied when all of them are known, since files put it anywhere.
#include <charconv>
#include <cmath>
#include <functional>
#include <limits>
#include <map>
#include <utility>

#include "can_protocol/dbc.hpp"
#include "can_protocol/dbc_cursor.hpp"
#include "can_protocol/dbc_draft.hpp"
#include "can_protocol/signal_layout.hpp"

namespace odomd::can {
namespace {

constexpr std::uint32_t extended_flag = 0x8000'0000U;
constexpr std::uint32_t largest_standard_id = 0x7FFU;
constexpr std::uint32_t largest_extended_id = 0x1FFF'FFFFU;
// Editors keep signals that belong to no message under this one.
constexpr std::uint64_t unused_signals_id = 0xC000'0000U;
constexpr std::uint64_t largest_u64 = std::numeric_limits<std::uint64_t>::max();

constexpr std::string_view signal_form =
    "write SG_ NAME : START|LENGTH@ORDER+ (FACTOR,OFFSET) [MIN|MAX] \"UNIT\" RECEIVER";
constexpr std::string_view message_form = "write BO_ ID NAME: LENGTH SENDER";
constexpr std::string_view id_form = "write the number that stands after BO_";

class Parser {
 public:
  Parser(std::string_view text, std::string file_name) : cursor_(text, std::move(file_name)) {}

  Database run() {
    while (!cursor_.at_end()) statement();
    cursor_.warn_if_cut_off();
    for (const auto& apply : later_) apply();
    Database database;
    for (DraftMessage& draft : drafts_) {
      apply_attributes(draft);
      resolve_multiplexing(draft, cursor_);
      warn_of_misfits(draft.message, cursor_);
      database.messages.push_back(std::move(draft.message));
    }
    database.file = cursor_.file_name();
    database.warnings = std::move(cursor_.warnings());
    std::stable_sort(database.warnings.begin(), database.warnings.end(),
                     [](const Warning& a, const Warning& b) { return a.line < b.line; });
    return database;
  }

 private:
  void statement() {
    if (cursor_.take_if(';')) return;
    const Token token = cursor_.peek();
    const std::string& keyword = token.text;
    if (token.kind == TokenKind::word) {
      cursor_.take();
      if (keyword == "BO_") return message(token.line);
      if (keyword == "SG_") return signal(token.line);
      if (keyword == "CM_") return comment();
      if (keyword == "VAL_") return value_names();
      if (keyword == "BA_") return attribute();
      if (keyword == "BA_DEF_") return attribute_definition();
      if (keyword == "BA_DEF_DEF_") return attribute_default();
      if (keyword == "SIG_VALTYPE_") return value_type();
      if (keyword == "SG_MUL_VAL_") return extended_multiplexing();
      if (keyword == "VERSION") return version();
      if (keyword == "NS_") return symbols();
      if (keyword == "BS_" || keyword == "BU_") return pass_over_list();
      if (keyword.size() > 1 && keyword.ends_with('_') &&
          keyword.find_first_not_of("ABCDEFGHIJKLMNOPQRSTUVWXYZ_") == std::string::npos)
        return cursor_.skip_statement(keyword);
    }
    cursor_.fail(token, "a statement such as BO_, SG_, CM_ or VAL_",
                 "remove it, or mend the statement before it");
  }

  // Statements that say nothing we need -----------------------------------------------------------

  void version() {
    cursor_.take_text("the version in quotes", "write VERSION \"\"");
    cursor_.take_if(';');
  }

  /// The symbols that the file may use, mostly one a line; they look like statements.
  void symbols() {
    cursor_.take_punctuation(':', "after NS_", "write NS_ :");
    while (cursor_.peek().kind == TokenKind::word) {
      const bool alone = cursor_.peek(1).starts_line || cursor_.peek(1).kind == TokenKind::end;
      if (cursor_.peek().starts_line && !alone) return;
      cursor_.take();
    }
  }

  /// BS_: and BU_:, which no ';' ends.
  void pass_over_list() {
    cursor_.take_punctuation(':', "after BS_ or BU_", "write BS_: or BU_: NODE ...");
    while (!cursor_.at_end() && !cursor_.at_statement()) cursor_.take();
  }

  // Messages and signals --------------------------------------------------------------------------

  struct Key {
    std::uint32_t id = 0;
    IdFormat format = IdFormat::standard;
    bool flag_missing = false;
  };

  /// Bit 31 of the number marks an extended identifier.
  Key identifier(const Token& token, std::uint64_t number) const {
    const auto id = static_cast<std::uint32_t>(number & ~std::uint64_t{extended_flag});
    if (number > std::numeric_limits<std::uint32_t>::max() || id > largest_extended_id)
      cursor_.fail(token, "an identifier of 11 or 29 bits",
                   "write the identifier, plus 2147483648 if it is an extended one");
    const bool flagged = (number & extended_flag) != 0;
    const bool extended = flagged || id > largest_standard_id;
    return {id, extended ? IdFormat::extended : IdFormat::standard, extended && !flagged};
  }

  void message(std::uint32_t line) {
    DraftMessage draft;
    Message& message = draft.message;
    const Token id_token = cursor_.peek();
    const std::uint64_t number =
        cursor_.take_unsigned("the message's identifier", largest_u64, message_form);
    message.name = cursor_.take_name("the message's name", message_form);
    cursor_.take_punctuation(':', "after the message's name", message_form);
    const std::uint64_t length =
        cursor_.take_unsigned("the message's length in bytes", 0xFFFF, message_form);
    if (cursor_.peek().kind == TokenKind::word && !cursor_.peek().starts_line)
      message.sender = cursor_.take().text;
    message.line = line;

    current_ = nullptr;
    inside_message_ = true;
    if (number == unused_signals_id) return;  // its signals are read and dropped
    const Key key = identifier(id_token, number);
    if (key.flag_missing)
      cursor_.warn(line, "identifier " + id_token.text + " of message '" + message.name +
                             "' has more than 11 bits but no extended flag; taken as extended");
    message.id = key.id;
    message.format = key.format;
    const auto [place, first] =
        by_key_.try_emplace(frame_key(key.id, key.format), std::optional<std::size_t>{});
    if (!first) {
      cursor_.warn(line, "message '" + message.name +
                             "' has the identifier of another one above; "
                             "left out");
      return;
    }
    if (length > max_payload) {
      cursor_.warn(line, "message '" + message.name + "' has " + std::to_string(length) +
                             " bytes, more than a frame; left out");
      return;
    }
    for (const DraftMessage& other : drafts_)
      if (other.message.name == message.name)
        cursor_.warn(line, "message '" + message.name +
                               "' has the name of another one above, "
                               "which is the one found by name");
    message.length = static_cast<std::uint8_t>(length);
    place->second = drafts_.size();
    current_ = &drafts_.emplace_back(std::move(draft));
  }

  void signal(std::uint32_t line) {
    Signal signal;
    DraftMultiplexing multiplexing;
    signal.line = line;
    const Token name = cursor_.peek();
    signal.name = cursor_.take_name("the signal's name", signal_form);
    if (!inside_message_)
      cursor_.fail(name, "a message (BO_) before the first signal", "put the signal below its BO_");
    if (!cursor_.at_punctuation(':')) multiplexing_of(signal, multiplexing);
    cursor_.take_punctuation(':', "after the signal's name", signal_form);
    const Token start = cursor_.peek();
    const std::uint64_t start_bit =
        cursor_.take_unsigned("the signal's start bit", max_payload * 8 - 1, signal_form);
    cursor_.take_punctuation('|', "after the start bit", signal_form);
    signal.length = static_cast<std::uint8_t>(
        cursor_.take_unsigned("the signal's length in bits, 1 to 64", 64, signal_form));
    if (signal.length == 0)
      cursor_.fail_at(line, "expected the length of signal '" + signal.name +
                                "', 1 to 64 bits, found 0; mend or remove the signal");
    cursor_.take_punctuation('@', "after the signal's length", signal_form);
    order_and_sign(signal);
    if (bytes_needed(static_cast<unsigned>(start_bit), signal.length, signal.byte_order) >
        max_payload)
      cursor_.fail(start, "a start bit from which signal '" + signal.name + "' fits 64 bytes",
                   "mend its start bit or its length");
    signal.start_bit = static_cast<std::uint16_t>(start_bit);
    scaling_and_range(signal);
    signal.unit = cursor_.take_text("the signal's unit in quotes", signal_form);
    while ((cursor_.peek().kind == TokenKind::word && !cursor_.at_statement()) ||
           cursor_.at_punctuation(','))
      cursor_.take();  // receivers
    add_signal(std::move(signal), std::move(multiplexing));
  }

  /// M, m3 or m3M.
  void multiplexing_of(Signal& signal, DraftMultiplexing& multiplexing) {
    const Token token = cursor_.peek();
    std::string_view word = token.text;
    if (word.ends_with('M')) {
      signal.is_multiplexor = true;
      word.remove_suffix(1);
    }
    if (word.starts_with('m')) {
      multiplexing.selected_by = unsigned_of(word.substr(1));
      if (multiplexing.selected_by) word = {};
    }
    if (token.kind != TokenKind::word || !word.empty())
      cursor_.fail(token, "':' or a multiplexing (M, m0, m0M) after the signal's name",
                   signal_form);
    cursor_.take();
  }

  void order_and_sign(Signal& signal) {
    const Token token = cursor_.peek();
    std::string word = cursor_.take_word("the byte order, 0 or 1", signal_form);
    if (word.size() == 1 && cursor_.peek().kind == TokenKind::word) word += cursor_.take().text;
    if (word.size() != 2 || (word[0] != '0' && word[0] != '1') ||
        (word[1] != '+' && word[1] != '-'))
      cursor_.fail(token, "byte order and sign, one of 1+ 1- 0+ 0-", signal_form);
    signal.byte_order = word[0] == '1' ? ByteOrder::little_endian : ByteOrder::big_endian;
    signal.type = word[1] == '-' ? ValueType::signed_integer : ValueType::unsigned_integer;
  }

  void scaling_and_range(Signal& signal) {
    cursor_.take_punctuation('(', "before the factor", signal_form);
    signal.scale = cursor_.take_number("the signal's factor", signal_form);
    cursor_.take_punctuation(',', "between factor and offset", signal_form);
    signal.offset = cursor_.take_number("the signal's offset", signal_form);
    cursor_.take_punctuation(')', "after the offset", signal_form);
    cursor_.take_punctuation('[', "before the range", signal_form);
    signal.minimum = cursor_.take_number("the signal's minimum", signal_form);
    cursor_.take_punctuation('|', "between minimum and maximum", signal_form);
    signal.maximum = cursor_.take_number("the signal's maximum", signal_form);
    cursor_.take_punctuation(']', "after the range", signal_form);
  }

  void add_signal(Signal signal, DraftMultiplexing multiplexing) {
    if (current_ == nullptr) return;
    if (find_signal(current_->message, signal.name) != nullptr) {
      cursor_.warn(signal.line, "message '" + current_->message.name + "' has two signals '" +
                                    signal.name + "'; the first is taken");
      return;
    }
    if (signal.scale == 0.0)
      cursor_.warn(signal.line, "signal '" + signal.name + "' has the factor 0");
    current_->message.signals.push_back(std::move(signal));
    current_->multiplexing.push_back(std::move(multiplexing));
  }

  // What refers to them ---------------------------------------------------------------------------

  struct Reference {
    std::uint32_t line = 0;
    std::string statement;
    std::uint32_t key = 0;
  };

  Reference reference(std::string statement) {
    const Token token = cursor_.peek();
    const std::uint64_t number =
        cursor_.take_unsigned("the identifier of a message", largest_u64, id_form);
    if (number == unused_signals_id) return {token.line, std::move(statement), extended_flag - 1};
    const Key key = identifier(token, number);
    return {token.line, std::move(statement), frame_key(key.id, key.format)};
  }

  /// The message, or null with a warning; without one if it was left out.
  DraftMessage* find(const Reference& reference) {
    if (reference.key == extended_flag - 1) return nullptr;
    const auto found = by_key_.find(reference.key);
    if (found == by_key_.end()) {
      cursor_.warn(reference.line, reference.statement + " names message " +
                                       std::to_string(reference.key & ~extended_flag) +
                                       ", which is not in the file; passed over");
      return nullptr;
    }
    return found->second ? &drafts_[*found->second] : nullptr;
  }

  /// Calls `apply(draft, index of the signal)` once everything is known.
  template <typename Apply>
  void with_signal(Reference reference, std::string name, Apply apply) {
    later_.emplace_back(
        [this, reference = std::move(reference), name = std::move(name), apply = std::move(apply)] {
          DraftMessage* draft = find(reference);
          if (draft == nullptr) return;
          const Signal* signal = find_signal(draft->message, name);
          if (signal == nullptr)
            cursor_.warn(reference.line, reference.statement + " names signal '" + name +
                                             "', which message '" + draft->message.name +
                                             "' does not have; passed over");
          else
            apply(*draft, static_cast<std::size_t>(signal - draft->message.signals.data()));
        });
  }

  void comment() {
    constexpr std::string_view form = "write CM_ SG_ ID SIGNAL \"text\";";
    const Token kind = cursor_.peek();
    if (kind.text == "BO_" && kind.kind == TokenKind::word) {
      cursor_.take();
      message_comment(reference("CM_ BO_"), form);
    } else if (kind.text == "SG_" && kind.kind == TokenKind::word) {
      cursor_.take();
      Reference of = reference("CM_ SG_");
      if (cursor_.peek().kind == TokenKind::text) {
        cursor_.warn(of.line, "CM_ SG_ names no signal; taken as the comment of the message");
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

  void message_comment(Reference of, std::string_view form) {
    std::string text = cursor_.take_text("the comment in quotes", form);
    later_.emplace_back([this, of = std::move(of), text = std::move(text)] {
      if (DraftMessage* draft = find(of)) draft->message.comment = text;
    });
  }

  void value_names() {
    constexpr std::string_view form = "write VAL_ ID SIGNAL 0 \"name\" 1 \"name\" ;";
    if (!unsigned_of(cursor_.peek().text))  // of an environment variable
      return cursor_.skip_statement("VAL_");
    Reference of = reference("VAL_");
    std::string name = cursor_.take_word("the signal's name", form);
    std::vector<ValueName> values;
    while (cursor_.peek().kind == TokenKind::word && !cursor_.at_statement()) {
      const Token token = cursor_.peek();
      const double raw = cursor_.take_number("a raw value", form);
      std::string text = cursor_.take_text("the value's name in quotes", form);
      // 2^63 as a double: beyond it no raw value can be meant.
      if (raw != std::nearbyint(raw) || std::abs(raw) >= 9223372036854775808.0)
        cursor_.warn(token.line, "VAL_ names " + show(token) + ", which is no raw value");
      else
        values.push_back({static_cast<std::int64_t>(raw), std::move(text)});
    }
    cursor_.end_statement("VAL_");
    with_signal(std::move(of), std::move(name), [values](DraftMessage& draft, std::size_t i) {
      draft.message.signals[i].values = values;
    });
  }

  void value_type() {
    constexpr std::string_view form = "write SIG_VALTYPE_ ID SIGNAL : 1;";
    Reference of = reference("SIG_VALTYPE_");
    std::string name = cursor_.take_word("the signal's name", form);
    cursor_.take_if(':');
    const std::uint64_t type =
        cursor_.take_unsigned("0 (integer), 1 (float) or 2 (double)", 2, form);
    cursor_.end_statement("SIG_VALTYPE_");
    if (type == 0) return;
    const std::uint32_t line = of.line;
    with_signal(
        std::move(of), std::move(name), [this, type, line](DraftMessage& draft, std::size_t i) {
          Signal& signal = draft.message.signals[i];
          const unsigned length = type == 1 ? 32 : 64;
          if (signal.length != length)
            cursor_.fail_at(line, "expected " + std::to_string(length) +
                                      " bits for the floating-point " + "signal '" + signal.name +
                                      "', found " + std::to_string(signal.length) +
                                      "; mend its SG_ or SIG_VALTYPE_");
          signal.type = type == 1 ? ValueType::float32 : ValueType::float64;
        });
  }

  void extended_multiplexing() {
    constexpr std::string_view form = "write SG_MUL_VAL_ ID SIGNAL MULTIPLEXOR 0-0, 2-5;";
    Reference of = reference("SG_MUL_VAL_");
    std::string name = cursor_.take_word("the signal's name", form);
    const Token multiplexor = cursor_.peek();
    cursor_.take_word("the multiplexor's name", form);
    std::vector<MultiplexRange> ranges;
    do {
      const Token token = cursor_.peek();
      const std::string word = cursor_.take_word("a range of multiplexor values", form);
      const std::size_t dash = word.find('-');
      const auto first = unsigned_of(std::string_view(word).substr(0, dash));
      const auto last =
          dash == std::string::npos ? first : unsigned_of(std::string_view(word).substr(dash + 1));
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

  void set_multiplexor(DraftMessage& draft, std::size_t i, std::uint32_t line,
                       const std::string& multiplexor, const std::vector<MultiplexRange>& ranges) {
    DraftMultiplexing& written = draft.multiplexing[i];
    auto& signals = draft.message.signals;
    const Signal* found = find_signal(draft.message, multiplexor);
    if (found == nullptr || (!written.multiplexor.empty() && written.multiplexor != multiplexor))
      cursor_.fail_at(line, "expected the one multiplexor of signal '" + signals[i].name +
                                "', found '" + multiplexor + "'; name a signal of message '" +
                                draft.message.name + "'");
    if (!found->is_multiplexor) {
      cursor_.warn(line, "signal '" + multiplexor +
                             "' is not marked as a multiplexor (M); taken "
                             "as one");
      signals[static_cast<std::size_t>(found - signals.data())].is_multiplexor = true;
    }
    written.multiplexor = multiplexor;
    written.ranges.insert(written.ranges.end(), ranges.begin(), ranges.end());
  }

  // Attributes: GenMsgCycleTime in milliseconds, VFrameFormat -------------------------------------

  void attribute_definition() {
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

  void attribute_default() {
    const std::string name = cursor_.peek().text;
    if (cursor_.peek(1).kind != TokenKind::end) {
      if (name == "GenMsgCycleTime") {
        cursor_.take();
        default_cycle_time_ms_ = cycle_time();
      } else if (name == "VFrameFormat") {
        cursor_.take();
        default_frame_format_ = cursor_.take().text;
      }
    }
    cursor_.skip_statement("BA_DEF_DEF_");
  }

  void attribute() {
    const std::string name = cursor_.peek().text;
    const bool of_message =
        cursor_.peek(1).text == "BO_" && cursor_.peek(1).kind == TokenKind::word;
    if (!of_message || (name != "GenMsgCycleTime" && name != "VFrameFormat"))
      return cursor_.skip_statement("BA_");
    cursor_.take();
    cursor_.take();
    const Reference of = reference("BA_ \"" + name + '"');
    if (name == "GenMsgCycleTime") {
      later_.emplace_back([this, of, ms = cycle_time()] {
        if (DraftMessage* draft = find(of)) draft->cycle_time_ms = ms;
      });
    } else {
      const std::string word = cursor_.take().text;
      later_.emplace_back([this, of, word] {
        const auto index = unsigned_of(word);
        if (DraftMessage* draft = find(of))
          draft->frame_format =
              index && *index < frame_formats_.size() ? frame_formats_[*index] : word;
      });
    }
    cursor_.end_statement("BA_");
  }

  double cycle_time() {
    const Token token = cursor_.peek();
    const double ms = cursor_.take_number("the cycle time in milliseconds",
                                          "write BA_ \"GenMsgCycleTime\" BO_ ID MILLISECONDS;");
    constexpr double longest_ms = 1e9;
    if (ms >= 0.0 && ms <= longest_ms) return ms;
    cursor_.warn(token.line, "no message has a cycle time of " + show(token) + " ms; passed over");
    return 0.0;
  }

  void apply_attributes(DraftMessage& draft) const {
    const double ms = draft.cycle_time_ms.value_or(default_cycle_time_ms_);
    draft.message.cycle_time_ns = std::llround(ms * 1e6);
    const std::string& format = draft.frame_format.value_or(default_frame_format_);
    const bool fd = format.ends_with("CAN_FD") || draft.message.length > 8;
    draft.message.protocol = fd ? FrameProtocol::fd : FrameProtocol::classic;
  }

  DbcCursor cursor_;
  std::vector<DraftMessage> drafts_;
  DraftMessage* current_ = nullptr;  ///< that signals are added to; null: they are dropped
  bool inside_message_ = false;
  std::map<std::uint32_t, std::optional<std::size_t>> by_key_;  ///< empty: left out
  std::vector<std::function<void()>> later_;
  std::vector<std::string> frame_formats_;
  std::string default_frame_format_;
  double default_cycle_time_ms_ = 0.0;
};

}  // namespace

Database parse_dbc(std::string_view text, std::string file_name) {
  return Parser(text, std::move(file_name)).run();
}

}  // namespace odomd::can
