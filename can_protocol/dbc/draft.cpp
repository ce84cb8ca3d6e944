// Resolves the multiplexing of a message and checks its plausibility, after all statements have
// been read.
#include "can_protocol/dbc/draft.hpp"

#include <algorithm>
#include <bitset>

#include "can_protocol/dbc/signal_layout.hpp"

namespace odomd::can {
namespace {

using Bits = std::bitset<max_payload * 8>;

/// Multiplexors in real databases are nested two or three deep.
constexpr std::size_t deepest_multiplexing = 16;

/// The multiplexors of a message, as marked in its SG_.
struct Multiplexors {
  std::optional<std::size_t> root;  ///< the last of the roots
  std::size_t roots = 0;
  std::size_t others = 0;
  bool all_usable = true;
};

Multiplexors multiplexors_of(const DraftMessage& draft) {
  Multiplexors found;
  for (std::size_t i = 0; i < draft.message.signals.size(); ++i) {
    if (!draft.message.signals[i].is_multiplexor) continue;
    if (draft.signals[i].left_out) found.all_usable = false;
    if (draft.signals[i].marked) {
      ++found.others;
    } else {
      ++found.roots;
      found.root = i;
    }
  }
  return found;
}

/// Gives a signal with a plain `m3` its multiplexor: the only one of the message.
void find_implied_multiplexor(DraftMessage& draft, std::size_t i, const Multiplexors& all,
                              DbcCursor& cursor) {
  Signal& signal = draft.message.signals[i];
  const std::size_t others = all.others - (signal.is_multiplexor ? 1 : 0);  // except itself
  const std::string name = "signal '" + signal.name + "'";
  if (all.roots == 0 && others == 0)
    return cursor.warn(signal.line, name + " is multiplexed, but message '" + draft.message.name +
                                        "' has no multiplexor; treated as always present");
  // The root selects a nested multiplexor; any other signal could have either as its multiplexor.
  if (all.roots != 1 || (others > 0 && !signal.is_multiplexor))
    return leave_out(draft, i, signal.line,
                     "expected one multiplexor for " + name + ", found " +
                         std::to_string(all.roots + others) + " in message '" + draft.message.name +
                         "'; say which by SG_MUL_VAL_",
                     cursor);
  if (!all.all_usable)
    return leave_out(draft, i, signal.line, "the multiplexor of " + name + " cannot be used",
                     cursor);
  signal.multiplexor = all.root;
  if (const auto value = draft.signals[i].selected_by) signal.selected_by = {{*value, *value}};
}

/// Leaves out a signal if its multiplexors form a cycle, are nested deeper than in any real
/// database, or are left out themselves.
void check_multiplexors_above(DraftMessage& draft, std::size_t i, DbcCursor& cursor) {
  const Message& message = draft.message;
  const Signal& signal = message.signals[i];
  const auto refuse = [&](const std::string& why) {
    leave_out(draft, i, signal.line, why, cursor);
  };
  const std::string fix = "; fix the SG_MUL_VAL_ of message '" + message.name + "'";
  std::vector<const Signal*> above;
  for (const Signal* at = &signal; at->multiplexor; at = &message.signals[*at->multiplexor]) {
    if (draft.signals[*at->multiplexor].left_out)
      return refuse("the multiplexor of signal '" + signal.name + "' cannot be used");
    if (std::find(above.begin(), above.end(), at) != above.end())
      return refuse("expected a multiplexor above signal '" + signal.name + "', found a cycle" +
                    fix);
    if (above.size() == deepest_multiplexing)
      return refuse("expected at most " + std::to_string(deepest_multiplexing) +
                    " multiplexors one above the other, found more above signal '" + signal.name +
                    "'" + fix);
    above.push_back(at);
  }
}

void drop_left_out(DraftMessage& draft) {
  std::vector<std::size_t> places;
  std::vector<Signal> kept;
  for (std::size_t i = 0; i < draft.signals.size(); ++i) {
    places.push_back(kept.size());
    if (!draft.signals[i].left_out) kept.push_back(std::move(draft.message.signals[i]));
  }
  for (Signal& signal : kept)
    if (signal.multiplexor) signal.multiplexor = places[*signal.multiplexor];
  draft.message.signals = std::move(kept);
}

/// Whether the multiplexor's bits can hold a value that selects the signal.
bool selectable(const Signal& signal, const Signal& multiplexor) {
  return std::any_of(signal.selected_by.begin(), signal.selected_by.end(), [&](const auto& range) {
    return range.first <= low_bits(multiplexor.length);
  });
}

bool disjoint(const std::vector<MultiplexRange>& a, const std::vector<MultiplexRange>& b) {
  return std::none_of(a.begin(), a.end(), [&](const MultiplexRange& x) {
    return std::any_of(b.begin(), b.end(), [&](const MultiplexRange& y) {
      return x.first <= y.last && y.first <= x.last;
    });
  });
}

/// Whether a common multiplexor selects at most one of the two signals. Also true when the effort
/// is exhausted.
bool exclusive(const Message& message, const Signal& a, const Signal& b, Effort& effort) {
  for (const Signal* x = &a; x->multiplexor; x = &message.signals[*x->multiplexor])
    for (const Signal* y = &b; y->multiplexor; y = &message.signals[*y->multiplexor]) {
      if (!effort.spend(1 + x->selected_by.size() * y->selected_by.size())) return true;
      if (x->multiplexor == y->multiplexor && disjoint(x->selected_by, y->selected_by)) return true;
    }
  return false;
}

/// One warning per signal, however many others it overlaps.
void warn_of_overlap(const Message& message, const Signal& signal, const Signal& first,
                     std::size_t others, DbcCursor& cursor) {
  if (others == 1)
    cursor.warn(signal.line, "signals '" + first.name + "' and '" + signal.name + "' of message '" +
                                 message.name + "' overlap");
  else
    cursor.warn(signal.line, "signal '" + signal.name + "' of message '" + message.name +
                                 "' overlaps '" + first.name + "' and " +
                                 std::to_string(others - 1) + " more");
}

Bits occupied_bits(const Signal& signal) {
  std::array<std::uint8_t, max_payload> payload{};
  insert_bits(layout_of(signal), ~std::uint64_t{0}, payload);
  Bits bits;
  for (std::size_t i = 0; i < bits.size(); ++i)
    bits[i] = (unsigned{payload[i / 8]} >> (i % 8) & 1U) != 0;
  return bits;
}

}  // namespace

std::optional<std::size_t> find_signal(const DraftMessage& draft, const std::string& name) {
  const auto found = draft.by_name.find(name);
  return found == draft.by_name.end() ? std::nullopt : std::optional(found->second);
}

void leave_out(DraftMessage& draft, std::size_t signal, std::uint32_t line, const std::string& why,
               DbcCursor& cursor) {
  if (draft.signals[signal].left_out) return;
  draft.signals[signal].left_out = true;
  const std::string& name = draft.message.signals[signal].name;
  draft.message.left_out.push_back({name, line, why});
  cursor.warn_left_out(line, why + "; signal '" + name + "' left out");
}

void resolve_signals(DraftMessage& draft, DbcCursor& cursor) {
  auto& signals = draft.message.signals;
  for (std::size_t i = 0; i < signals.size(); ++i)
    if (!draft.signals[i].left_out && layout_of(signals[i]).bytes_needed > draft.message.length)
      leave_out(draft, i, signals[i].line,
                "signal '" + signals[i].name + "' ends beyond the " +
                    std::to_string(draft.message.length) + " bytes of message '" +
                    draft.message.name + "'",
                cursor);
  const Multiplexors all = multiplexors_of(draft);
  for (std::size_t i = 0; i < signals.size(); ++i) {
    const DraftSignal& written = draft.signals[i];
    if (written.left_out) continue;
    if (!written.multiplexor.empty()) {
      signals[i].multiplexor = find_signal(draft, written.multiplexor);
      signals[i].selected_by = written.ranges;
    } else if (written.marked) {
      find_implied_multiplexor(draft, i, all, cursor);
    }
  }
  for (std::size_t i = 0; i < signals.size(); ++i) check_multiplexors_above(draft, i, cursor);
  drop_left_out(draft);
  for (const Signal& signal : signals) {
    if (signal.multiplexor && signal.selected_by.empty())
      cursor.warn(signal.line, "signal '" + signal.name +
                                   "' is never present: no value of multiplexor '" +
                                   signals[*signal.multiplexor].name +
                                   "' selects it; write the value after its m, or SG_MUL_VAL_");
    else if (signal.multiplexor && !selectable(signal, signals[*signal.multiplexor]))
      cursor.warn(signal.line, "signal '" + signal.name + "' is never present: multiplexor '" +
                                   signals[*signal.multiplexor].name +
                                   "' has no bits for a value that selects it");
  }
}

void warn_of_overlaps(const Message& message, Effort& effort, DbcCursor& cursor) {
  std::vector<Bits> bits;
  for (const Signal& signal : message.signals) bits.push_back(occupied_bits(signal));
  for (std::size_t i = 0; i < bits.size(); ++i) {
    const Signal* first = nullptr;
    std::size_t others = 0;
    for (std::size_t j = 0; j < i && effort.spend(1); ++j) {
      const Signal& other = message.signals[j];
      if ((bits[i] & bits[j]).none() || exclusive(message, message.signals[i], other, effort))
        continue;
      if (others++ == 0) first = &other;
    }
    if (others > 0) warn_of_overlap(message, message.signals[i], *first, others, cursor);
  }
}

}  // namespace odomd::can
