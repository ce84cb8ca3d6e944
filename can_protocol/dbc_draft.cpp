// Multiplexing and plausibility of one message, once all its statements have been read.
#include "can_protocol/dbc_draft.hpp"

#include <algorithm>
#include <bitset>

#include "can_protocol/signal_layout.hpp"

namespace odomd::can {
namespace {

using Bits = std::bitset<max_payload * 8>;

std::optional<std::size_t> index_of(const Message& message, const std::string& name) {
  for (std::size_t i = 0; i < message.signals.size(); ++i)
    if (message.signals[i].name == name) return i;
  return std::nullopt;
}

/// The multiplexor that a plain `m3` means: the only one there is.
std::optional<std::size_t> implied_multiplexor(const DraftMessage& draft, std::size_t signal,
                                               DbcCursor& cursor) {
  const auto& signals = draft.message.signals;
  std::optional<std::size_t> root;
  std::size_t roots = 0;
  std::size_t others = 0;
  for (std::size_t i = 0; i < signals.size(); ++i) {
    if (i == signal || !signals[i].is_multiplexor) continue;
    if (draft.multiplexing[i].selected_by) {
      ++others;
    } else {
      ++roots;
      root = i;
    }
  }
  if (roots == 0 && others == 0) {
    cursor.warn(signals[signal].line, "signal '" + signals[signal].name +
                                          "' is multiplexed, but message '" + draft.message.name +
                                          "' has no multiplexor; taken as always present");
    return std::nullopt;
  }
  // A nested multiplexor is selected by the root; any other signal might be by either.
  if (roots != 1 || (others > 0 && !signals[signal].is_multiplexor))
    cursor.fail_at(signals[signal].line, "expected one multiplexor for signal '" +
                                             signals[signal].name + "', found " +
                                             std::to_string(roots + others) + " in message '" +
                                             draft.message.name + "'; say which by SG_MUL_VAL_");
  return root;
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

/// Whether no payload can hold both: somewhere up their chains one multiplexor decides.
bool exclusive(const Message& message, const Signal& a, const Signal& b) {
  for (const Signal* x = &a; x->multiplexor; x = &message.signals[*x->multiplexor])
    for (const Signal* y = &b; y->multiplexor; y = &message.signals[*y->multiplexor])
      if (x->multiplexor == y->multiplexor && disjoint(x->selected_by, y->selected_by)) return true;
  return false;
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

void resolve_multiplexing(DraftMessage& draft, DbcCursor& cursor) {
  auto& signals = draft.message.signals;
  for (std::size_t i = 0; i < signals.size(); ++i) {
    const DraftMultiplexing& written = draft.multiplexing[i];
    if (!written.multiplexor.empty()) {
      signals[i].multiplexor = index_of(draft.message, written.multiplexor);
      signals[i].selected_by = written.ranges;
    } else if (written.selected_by) {
      signals[i].multiplexor = implied_multiplexor(draft, i, cursor);
      if (signals[i].multiplexor)
        signals[i].selected_by = {{*written.selected_by, *written.selected_by}};
    }
  }
  for (const Signal& signal : signals) {
    if (signal.multiplexor && !selectable(signal, signals[*signal.multiplexor]))
      cursor.warn(signal.line, "signal '" + signal.name + "' is never present: multiplexor '" +
                                   signals[*signal.multiplexor].name +
                                   "' has no bits for a value that selects it");
    std::size_t steps = 0;
    for (const Signal* at = &signal; at->multiplexor; at = &signals[*at->multiplexor])
      if (++steps > signals.size())
        cursor.fail_at(signal.line, "expected a multiplexor above signal '" + signal.name +
                                        "', found a circle; mend the SG_MUL_VAL_ of message '" +
                                        draft.message.name + "'");
  }
}

void warn_of_misfits(const Message& message, DbcCursor& cursor) {
  std::vector<Bits> bits;
  for (const Signal& signal : message.signals) {
    bits.push_back(occupied_bits(signal));
    if (layout_of(signal).bytes_needed > message.length)
      cursor.warn(signal.line, "signal '" + signal.name + "' ends beyond the " +
                                   std::to_string(message.length) + " bytes of message '" +
                                   message.name + "'");
  }
  for (std::size_t i = 0; i < bits.size(); ++i)
    for (std::size_t j = 0; j < i; ++j)
      if ((bits[i] & bits[j]).any() && !exclusive(message, message.signals[i], message.signals[j]))
        cursor.warn(message.signals[i].line, "signals '" + message.signals[j].name + "' and '" +
                                                 message.signals[i].name + "' of message '" +
                                                 message.name + "' overlap");
}

}  // namespace odomd::can
