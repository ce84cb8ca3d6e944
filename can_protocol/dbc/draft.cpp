// Resolves the multiplexing of a message and checks its plausibility, after all statements have
// been read.
#include "can_protocol/dbc/draft.hpp"

#include <algorithm>
#include <bitset>

#include "can_protocol/dbc/signal_layout.hpp"

namespace odomd::can {
namespace {

using Bits = std::bitset<max_payload * 8>;

/// Real databases are nested two or three deep.
constexpr std::size_t deepest_multiplexing = 16;

/// The multiplexors of a message, as marked in its SG_.
struct Multiplexors {
  std::optional<std::size_t> root;  ///< the last of the roots
  std::size_t roots = 0;
  std::size_t others = 0;
};

Multiplexors multiplexors_of(const DraftMessage& draft) {
  Multiplexors found;
  for (std::size_t i = 0; i < draft.message.signals.size(); ++i) {
    if (!draft.message.signals[i].is_multiplexor) continue;
    if (draft.multiplexing[i].marked) {
      ++found.others;
    } else {
      ++found.roots;
      found.root = i;
    }
  }
  return found;
}

/// The multiplexor of a plain `m3`: the only one of the message.
std::optional<std::size_t> implied_multiplexor(const DraftMessage& draft, const Multiplexors& all,
                                               const Signal& signal, DbcCursor& cursor) {
  const std::size_t others = all.others - (signal.is_multiplexor ? 1 : 0);  // except itself
  if (all.roots == 0 && others == 0) {
    cursor.warn(signal.line, "signal '" + signal.name + "' is multiplexed, but message '" +
                                 draft.message.name +
                                 "' has no multiplexor; treated as always present");
    return std::nullopt;
  }
  // A nested multiplexor is selected by the root; any other signal could be selected by either.
  if (all.roots != 1 || (others > 0 && !signal.is_multiplexor))
    cursor.fail_at(signal.line, "expected one multiplexor for signal '" + signal.name +
                                    "', found " + std::to_string(all.roots + others) +
                                    " in message '" + draft.message.name +
                                    "'; say which by SG_MUL_VAL_");
  return all.root;
}

/// Rejects cycles of multiplexors, and nesting deeper than in any real database.
void check_depth(const Message& message, const Signal& signal, DbcCursor& cursor) {
  std::vector<const Signal*> above;
  for (const Signal* at = &signal; at->multiplexor; at = &message.signals[*at->multiplexor]) {
    if (std::find(above.begin(), above.end(), at) != above.end())
      cursor.fail_at(signal.line, "expected a multiplexor above signal '" + signal.name +
                                      "', found a cycle; fix the SG_MUL_VAL_ of message '" +
                                      message.name + "'");
    if (above.size() == deepest_multiplexing)
      cursor.fail_at(signal.line, "expected at most " + std::to_string(deepest_multiplexing) +
                                      " multiplexors one above the other, found more above "
                                      "signal '" +
                                      signal.name + "'; fix the SG_MUL_VAL_ of message '" +
                                      message.name + "'");
    above.push_back(at);
  }
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

/// Whether no payload can hold both because a common multiplexor excludes it. Returns true when the
/// effort is exhausted.
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

void resolve_multiplexing(DraftMessage& draft, DbcCursor& cursor) {
  auto& signals = draft.message.signals;
  const Multiplexors all = multiplexors_of(draft);
  for (std::size_t i = 0; i < signals.size(); ++i) {
    const DraftMultiplexing& written = draft.multiplexing[i];
    if (!written.multiplexor.empty()) {
      signals[i].multiplexor = find_signal(draft, written.multiplexor);
      signals[i].selected_by = written.ranges;
    } else if (written.marked) {
      signals[i].multiplexor = implied_multiplexor(draft, all, signals[i], cursor);
      if (signals[i].multiplexor && written.selected_by)
        signals[i].selected_by = {{*written.selected_by, *written.selected_by}};
    }
  }
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
    check_depth(draft.message, signal, cursor);
  }
}

void warn_of_misfits(const Message& message, Effort& effort, DbcCursor& cursor) {
  std::vector<Bits> bits;
  for (const Signal& signal : message.signals) {
    bits.push_back(occupied_bits(signal));
    if (layout_of(signal).bytes_needed > message.length)
      cursor.warn(signal.line, "signal '" + signal.name + "' ends beyond the " +
                                   std::to_string(message.length) + " bytes of message '" +
                                   message.name + "'");
  }
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
