// Compiles what must hold for a value to count. Internal to the decoder.
#pragma once

#include <string>
#include <vector>

#include "can_protocol/decode/decoder_tables.hpp"

namespace odomd::can {

/// Throws std::invalid_argument that names the role, as all functions here do.
[[noreturn]] void refuse(const SignalBinding& binding, const std::string& text);

/// The signal's bits for a physical value that it can have.
[[nodiscard]] CompiledMatch compile_match(const SignalBinding& binding, const Signal& signal,
                                          double value);

[[nodiscard]] CompiledCondition compile_condition(const SignalBinding& binding,
                                                  const Signal& signal, const ValidWhen& condition);

/// Appends that a signal of the binding has none of the raw values of unless_raw.
void add_unless_raw(const SignalBinding& binding, const Signal& signal,
                    std::vector<CompiledCondition>& conditions);

}  // namespace odomd::can
