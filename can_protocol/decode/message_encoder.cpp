// Encodes messages.
#include "can_protocol/decode/message_encoder.hpp"

#include <algorithm>
#include <cmath>
#include <stdexcept>
#include <string>
#include <utility>

#include "can_protocol/dbc/signal_layout.hpp"
#include "can_protocol/decode/name_hints.hpp"

namespace odomd::can {

MessageEncoder::MessageEncoder(Message message) : message_(std::move(message)) {}

MessageEncoder::MessageEncoder(Message message, const E2eBinding& protection)
    : message_(std::move(message)) {
  protection_.emplace(message_, protection);
}

const Signal& MessageEncoder::require(std::string_view signal) const {
  const Signal* found = find_signal(message_, signal);
  if (found == nullptr)
    throw std::invalid_argument("message '" + message_.name + "' has no signal '" +
                                std::string(signal) + "'" + nearest_signal_hint(message_, signal));
  return *found;
}

void MessageEncoder::set(std::string_view signal, double physical) {
  const Signal& target = require(signal);
  const bool integer =
      target.type == ValueType::unsigned_integer || target.type == ValueType::signed_integer;
  if (integer && std::isnan(physical))
    throw std::invalid_argument("signal '" + message_.name + '.' + target.name +
                                "' cannot hold a value that is not a number; give it a number");
  insert(target, bits_for(layout_of(target), physical));
}

void MessageEncoder::set_bits(std::string_view signal, std::uint64_t bits) {
  insert(require(signal), bits);
}

void MessageEncoder::insert(const Signal& signal, std::uint64_t bits) {
  for (const Signal* at = &signal; at->multiplexor; at = &message_.signals[*at->multiplexor])
    if (at->selected_by.empty())
      throw std::invalid_argument("signal '" + message_.name + '.' + at->name +
                                  "' is never present: no value of its multiplexor selects it; "
                                  "name one in the database");
  insert_bits(layout_of(signal), bits, payload_);
  for (const Signal* at = &signal; at->multiplexor;) {
    const Signal& multiplexor = message_.signals[*at->multiplexor];
    const SignalLayout layout = layout_of(multiplexor);
    if (!is_selected(at->selected_by, extract_bits(layout, payload_)))
      insert_bits(layout, at->selected_by.front().first, payload_);
    at = &multiplexor;
  }
}

Frame MessageEncoder::frame(std::int64_t time_ns, std::uint8_t bus) {
  if (protection_) protection_->protect(payload_, protection_state_);
  Frame frame;
  frame.time_ns = time_ns;
  frame.id = message_.id;
  frame.format = message_.format;
  frame.protocol = message_.protocol;
  frame.bus = bus;
  frame.length = message_.length;
  std::copy_n(payload_.begin(), message_.length, frame.data.begin());
  return frame;
}

}  // namespace odomd::can
