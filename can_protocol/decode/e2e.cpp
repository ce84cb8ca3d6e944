// Checks and protects payloads.
#include "can_protocol/decode/e2e.hpp"

#include <algorithm>
#include <stdexcept>
#include <string>

#include "can_protocol/decode/name_hints.hpp"

namespace odomd::can {
namespace {

bool is_profile_1(E2eProfile profile) {
  return profile == E2eProfile::p01 || profile == E2eProfile::p11;
}
bool is_profile_2(E2eProfile profile) {
  return profile == E2eProfile::p02 || profile == E2eProfile::p22;
}
bool has_crc(E2eProfile profile) {
  return is_profile_1(profile) || is_profile_2(profile) || profile == E2eProfile::sae_j1850;
}

[[noreturn]] void refuse(const Message& message, const std::string& text) {
  throw std::invalid_argument("end-to-end protection of message '" + message.name + "': " + text);
}

const Signal& require_signal(const Message& message, const std::string& name,
                             const std::string& what) {
  if (name.empty()) refuse(message, "no " + what + " is named; add it");
  const Signal* signal = find_signal(message, name);
  if (signal == nullptr)
    refuse(message,
           what + " '" + name + "' is not one of its signals" + nearest_signal_hint(message, name));
  if (signal->multiplexor) refuse(message, what + " '" + name + "' is multiplexed; name another");
  if (signal->type != ValueType::unsigned_integer)
    refuse(message, what + " '" + name + "' is not an unsigned integer; name another");
  if (layout_of(*signal).bytes_needed > message.length)
    refuse(message, what + " '" + name + "' lies beyond the message's end; fix the database");
  return *signal;
}

// The CRC before the payload's first byte, for even and odd counters: profiles 1 and 11 begin with
// the data id.
std::array<std::uint8_t, 2> crc_start(const E2eBinding& binding) {
  if (!is_profile_1(binding.profile)) return {0xFF, 0xFF};
  const auto low = static_cast<std::uint8_t>(binding.data_id & 0xFFU);
  const auto high = static_cast<std::uint8_t>(binding.data_id >> 8U);
  const std::uint8_t after_low = CrcJ1850::update(0x00, low);
  switch (binding.data_id_mode) {
    case DataIdMode::both: {
      const std::uint8_t after_both = CrcJ1850::update(after_low, high);
      return {after_both, after_both};
    }
    case DataIdMode::alternating:
      return {after_low, CrcJ1850::update(0x00, high)};
    case DataIdMode::low:
      return {after_low, after_low};
    case DataIdMode::nibble: {
      const std::uint8_t after_zero = CrcJ1850::update(after_low, std::uint8_t{0x00});
      return {after_zero, after_zero};
    }
  }
  return {};
}

}  // namespace

E2eProtection::E2eProtection(const Message& message, const E2eBinding& binding)
    : profile_(binding.profile), length_(message.length), max_delta_(binding.max_delta_counter) {
  if (profile_ == E2eProfile::none) return;
  if (max_delta_ == 0) refuse(message, "max_delta_counter is 0; the least is 1");

  if (has_crc(profile_)) {
    const Signal& crc = require_signal(message, binding.crc_signal, "crc signal");
    // The start bit of a whole byte is its bit 0 (little-endian) or its bit 7 (big-endian).
    const unsigned aligned = crc.byte_order == ByteOrder::little_endian ? 0 : 7;
    if (crc.length != 8 || crc.start_bit % 8 != aligned)
      refuse(message, "crc signal '" + crc.name + "' is not a whole byte; name another");
    crc_byte_ = static_cast<std::uint8_t>(crc.start_bit / 8);
    crc_start_ = crc_start(binding);
    crc_final_xor_ = is_profile_1(profile_) ? 0x00 : 0xFF;
  } else if (!binding.crc_signal.empty()) {
    refuse(message, "a plain counter has no crc signal; remove it, or name another profile");
  }

  // A checksum without a counter is allowed.
  if (profile_ == E2eProfile::sae_j1850 && binding.counter_signal.empty()) return;
  const Signal& counter = require_signal(message, binding.counter_signal, "counter signal");
  counter_ = layout_of(counter);
  if (is_profile_1(profile_) || is_profile_2(profile_)) {
    if (counter.length != 4)
      refuse(message, "counter signal '" + counter.name + "' has " +
                          std::to_string(counter.length) + " bits instead of 4; name another");
    counter_values_ = is_profile_1(profile_) ? 15 : 16;
  } else {
    if (counter.length > 32)
      refuse(message, "counter signal '" + counter.name + "' has more than 32 bits; name another");
    counter_values_ = std::uint64_t{1} << counter.length;
  }

  if (is_profile_1(profile_) && binding.data_id_mode == DataIdMode::nibble) {
    if (binding.data_id > 0xFFF)
      refuse(message, "data_id is wider than the 12 bits of the NIBBLE mode; fix one of them");
    const unsigned low_bit = counter.byte_order == ByteOrder::little_endian
                                 ? counter.start_bit % 8U
                                 : (counter.start_bit + 5U) % 8U;
    if (low_bit % 4 != 0)
      refuse(message, "counter signal '" + counter.name +
                          "' is not half a byte, which the NIBBLE mode needs; name another");
    data_id_nibble_ = static_cast<std::uint8_t>(binding.data_id >> 8U);
    nibble_ = {1.0,
               0.0,
               static_cast<std::uint16_t>(counter.start_bit / 8 * 8 + (low_bit == 0 ? 4 : 0)),
               4,
               static_cast<std::uint8_t>(counter.start_bit / 8 + 1),
               ByteOrder::little_endian,
               ValueType::unsigned_integer};
  }
  if (is_profile_2(profile_)) {
    if (binding.data_id_list.size() != data_id_list_.size())
      refuse(message, "data_id_list has " + std::to_string(binding.data_id_list.size()) +
                          " entries instead of 16; fix it");
    std::copy(binding.data_id_list.begin(), binding.data_id_list.end(), data_id_list_.begin());
  }
}

std::uint8_t E2eProtection::crc(std::span<const std::uint8_t> payload,
                                std::uint32_t counter) const noexcept {
  const auto before = payload.first(*crc_byte_);
  const auto behind = payload.subspan(*crc_byte_ + 1U, length_ - *crc_byte_ - 1U);
  const std::uint8_t start = crc_start_[counter % 2];
  if (is_profile_2(profile_)) {
    const std::uint8_t crc = CrcH2f::update(CrcH2f::update(start, before), behind);
    return CrcH2f::update(crc, data_id_list_[counter % data_id_list_.size()]) ^ crc_final_xor_;
  }
  return CrcJ1850::update(CrcJ1850::update(start, before), behind) ^ crc_final_xor_;
}

E2eStatus E2eProtection::check(std::span<const std::uint8_t> payload,
                               E2eState& state) const noexcept {
  if (payload.empty()) return E2eStatus::no_new_data;
  if (profile_ == E2eProfile::none) return E2eStatus::ok;
  if (payload.size() < length_) return E2eStatus::error;

  std::uint32_t counter = 0;
  if (counter_values_ != 0) {
    counter = static_cast<std::uint32_t>(extract_bits(counter_, payload));
    if (counter >= counter_values_) return E2eStatus::error;
  }
  if (crc_byte_ && payload[*crc_byte_] != crc(payload, counter)) return E2eStatus::error;
  if (nibble_.length != 0 && extract_bits(nibble_, payload) != data_id_nibble_)
    return E2eStatus::error;
  if (counter_values_ == 0) return E2eStatus::ok;

  const std::optional<std::uint32_t> last = state.counter;
  state.counter = counter;
  if (!last) return E2eStatus::ok;
  const std::uint64_t step =
      std::uint64_t{counter} - *last + (counter < *last ? counter_values_ : 0);
  if (step == 0) return E2eStatus::repeated;
  if (step == 1) return E2eStatus::ok;
  return step <= max_delta_ ? E2eStatus::ok_some_lost : E2eStatus::wrong_sequence;
}

void E2eProtection::protect(std::span<std::uint8_t> payload, E2eState& state) const noexcept {
  if (profile_ == E2eProfile::none) return;
  std::uint32_t counter = 0;
  if (counter_values_ != 0) {
    if (state.counter)
      counter = static_cast<std::uint32_t>((std::uint64_t{*state.counter} + 1) % counter_values_);
    state.counter = counter;
    insert_bits(counter_, counter, payload);
  }
  if (nibble_.length != 0) insert_bits(nibble_, data_id_nibble_, payload);
  if (crc_byte_) payload[*crc_byte_] = crc(payload, counter);
}

}  // namespace odomd::can
