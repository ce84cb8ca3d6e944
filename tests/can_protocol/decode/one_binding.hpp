// A binding of one signal, and the decoder's error for it.
#pragma once

#include <string>
#include <utility>
#include <vector>

#include "can_protocol/decode/decoder.hpp"
#include "tests/scratch.hpp"

namespace odomd::can {

inline SignalBinding binding_of(std::string message, std::string signal,
                                std::uint16_t channel = 0) {
  SignalBinding binding;
  binding.channel = channel;
  binding.role = "role_" + std::to_string(channel);
  binding.message = std::move(message);
  binding.signals = {std::move(signal)};
  return binding;
}

/// Why the bindings are refused; empty if accepted.
inline std::string refusal(const Database& database, const std::vector<SignalBinding>& bindings) {
  return message_of([&] { const Decoder decoder({&database, 1}, bindings, {}, {}); });
}

}  // namespace odomd::can
